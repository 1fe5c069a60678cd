/** The plan being made: read from the mission, changed here, checked by the service a moment after every change. */
import { useEffect, useRef, useState } from "preact/hooks";
import { checkPlan, readPlan } from "../../api/plans";
import type { Plan, PlanReport } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";

const CHECK_AFTER_MS = 400;

interface Draft {
  readonly missionId: string;
  readonly plan: Plan;
  /** What the mission flew by when it was read. */
  readonly flown: Plan;
  readonly revision: number;
}

/** Survives a look at another view. */
let kept: Draft | null = null;

export interface PlanEditor {
  /** Null until it could be read. */
  readonly plan: Plan | null;
  /** Why it could not be read. */
  readonly failure: string | null;
  readonly isChanged: boolean;
  /** Whether the mission has got another plan since this one was read. */
  readonly isOvertaken: boolean;
  readonly report: PlanReport | null;
  /** Why the service could not check it. */
  readonly checkFailure: string | null;
  /** Whether the report is of an earlier state of the plan. */
  readonly isChecking: boolean;
  change(plan: Plan): void;
  /** Take what the mission flies by, now. */
  reload(): void;
}

export function usePlan(): PlanEditor {
  const { state, mayCommand, isConnected } = useShell();
  const missionId = state.mission?.mission_id ?? "";
  const hasOrigin = state.mission?.origin !== null;
  // A plan in metres has no degrees before its origin is known; there is none to read in a record.
  const isReadable = state.capabilities.planning && (hasOrigin || state.mission?.area.length === 0);
  const revision = state.planRevision;
  const [draft, setDraft] = useState(() => (kept?.missionId === missionId ? kept : null));
  const [failure, setFailure] = useState<string | null>(null);
  const [checked, setChecked] = useState<{ plan: Plan; report: PlanReport | null; failure: string | null } | null>(
    null,
  );
  kept = draft;
  const isChanged = draft !== null && draft.plan !== draft.flown;
  const newest = useRef(0);

  const reload = async (): Promise<void> => {
    const mine = ++newest.current;
    const answer = await readPlan();
    if (mine !== newest.current) return;
    setFailure(answer.ok ? null : answer.message);
    if (answer.ok) setDraft({ missionId, plan: answer.value, flown: answer.value, revision });
  };
  useEffect(() => {
    // The draft, too: the mission may have got another plan while this one was being read.
    const isCurrent = draft?.missionId === missionId && (isChanged || draft.revision === revision);
    if (missionId !== "" && isConnected && isReadable && !isCurrent) void reload();
  }, [missionId, isReadable, revision, isConnected, draft]);

  const plan = draft?.plan ?? null;
  const isCheckable = plan !== null && mayCommand && isConnected;
  useEffect(() => {
    if (!isCheckable) return undefined;
    let isWanted = true;
    const timer = setTimeout(async () => {
      const answer = await checkPlan(plan);
      if (!isWanted) return;
      const [report, message] = answer.ok ? [answer.value, null] : [null, answer.message];
      setChecked({ plan, report, failure: message });
    }, CHECK_AFTER_MS);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [plan, isCheckable, revision, hasOrigin]);

  return {
    plan,
    failure: state.capabilities.planning ? failure : texts.plan.notHere,
    isChanged,
    isOvertaken: draft !== null && draft.revision !== revision,
    report: checked?.report ?? null,
    checkFailure: checked?.failure ?? null,
    isChecking: checked?.plan !== plan,
    change: (changed) => setDraft((before) => before && { ...before, plan: changed }),
    reload: () => void reload(),
  };
}
