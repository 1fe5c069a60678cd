/** The plan being made: read from the mission, changed here, checked by the service a moment after every change. */
import { useEffect, useRef, useState } from "preact/hooks";
import { checkPlan, readPlan } from "../../api/plans";
import type { Plan, PlanReport } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { begun, changed, type History, redone, undone } from "./history";
import type { Undo } from "./use_undo_keys";

const CHECK_AFTER_MS = 400;
/** When the service has had too many plans to check. */
const CHECK_AGAIN_MS = 1500;
const TOO_MANY_REQUESTS = 429;

interface Draft {
  readonly missionId: string;
  readonly history: History;
  /** What the mission flew by when it was read. */
  readonly flown: Plan;
  readonly revision: number;
}

/** Survives a look at another view, with all that can be undone. */
let kept: Draft | null = null;

export interface PlanEditor extends Undo {
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
  const { state, isConnected } = useShell();
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
  const isChanged = draft !== null && draft.history.plan !== draft.flown;
  const newest = useRef(0);
  /** The check that is on its way: one at a time, since only the newest plan counts. */
  const pending = useRef<Promise<unknown>>(Promise.resolve());

  const reload = async (): Promise<void> => {
    const mine = ++newest.current;
    const answer = await readPlan();
    if (mine !== newest.current) return;
    setFailure(answer.ok ? null : answer.message);
    if (answer.ok) setDraft({ missionId, history: begun(answer.value), flown: answer.value, revision });
  };
  useEffect(() => {
    // The draft, too: the mission may have got another plan while this one was being read.
    const isCurrent = draft?.missionId === missionId && (isChanged || draft.revision === revision);
    if (missionId !== "" && isConnected && isReadable && !isCurrent) void reload();
  }, [missionId, isReadable, revision, isConnected, draft]);

  const plan = draft?.history.plan ?? null;
  const isCheckable = plan !== null && isConnected;
  useEffect(() => {
    if (!isCheckable) return undefined;
    let isWanted = true;
    let timer: ReturnType<typeof setTimeout>;
    const check = async (): Promise<void> => {
      await pending.current;
      if (!isWanted) return;
      const asked = checkPlan(plan);
      pending.current = asked;
      const answer = await asked;
      if (!isWanted) return;
      if (!answer.ok && answer.status === TOO_MANY_REQUESTS) {
        timer = setTimeout(check, CHECK_AGAIN_MS);
        return;
      }
      const [report, message] = answer.ok ? [answer.value, null] : [null, answer.message];
      setChecked({ plan, report, failure: message });
    };
    timer = setTimeout(check, CHECK_AFTER_MS);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [plan, isCheckable, revision, hasOrigin]);

  const step = (take: (before: History) => History): void =>
    setDraft((before) => before && { ...before, history: take(before.history) });
  return {
    plan,
    failure: state.capabilities.planning ? failure : texts.plan.notHere,
    isChanged,
    isOvertaken: draft !== null && draft.revision !== revision,
    report: checked?.report ?? null,
    checkFailure: checked?.failure ?? null,
    isChecking: checked?.plan !== plan,
    canUndo: draft !== null && draft.history.past.length > 0,
    canRedo: draft !== null && draft.history.future.length > 0,
    undo: () => step(undone),
    redo: () => step(redone),
    change: (wanted) => step((before) => changed(before, wanted, performance.now())),
    reload: () => void reload(),
  };
}
