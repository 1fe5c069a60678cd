/** Hook for the plan being edited: read from the mission, and checked by the station shortly after every change. */
import { useEffect, useRef, useState } from "preact/hooks";
import { checkPlan, readPlan } from "../../api/plans";
import type { Plan, PlanReport } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { afterReading, type Draft, isEdited } from "./draft";
import { changed, type History, redone, undone } from "./history";
import type { Undo } from "./use_undo_keys";

const CHECK_AFTER_MS = 400;
/** Delay after the station has refused a check because of too many requests. */
const CHECK_AGAIN_MS = 1500;
const TOO_MANY_REQUESTS = 429;

/** Draft that is kept, with its undo history, while another view is open. */
let kept: Draft | null = null;

export interface PlanEditor extends Undo {
  /** Null until the plan has been read. */
  readonly plan: Plan | null;
  /** Reason why the plan cannot be read. */
  readonly failure: string | null;
  readonly isChanged: boolean;
  /** Whether the plan of the mission has changed since it was read. */
  readonly isOvertaken: boolean;
  readonly report: PlanReport | null;
  /** Reason why the station could not check the plan. */
  readonly checkFailure: string | null;
  /** Whether the report belongs to an earlier state of the plan. */
  readonly isChecking: boolean;
  change(plan: Plan): void;
  /** Discard the draft and read the plan of the mission again. */
  reload(): void;
}

export function usePlan(): PlanEditor {
  const { state, isConnected } = useShell();
  const missionId = state.mission?.mission_id ?? "";
  const hasOrigin = state.mission?.origin !== null;
  // Without an origin, places in metres cannot be converted to degrees; recordings have no plan to read.
  const isReadable = state.capabilities.planning && (hasOrigin || state.mission?.area.length === 0);
  const revision = state.planRevision;
  const [draft, setDraft] = useState(() => (kept?.missionId === missionId ? kept : null));
  const [failure, setFailure] = useState<string | null>(null);
  const [checked, setChecked] = useState<{ plan: Plan; report: PlanReport | null; failure: string | null } | null>(
    null,
  );
  kept = draft;
  const isChanged = isEdited(draft);
  const newest = useRef(0);
  /** Pending check: one at a time, since only the latest plan counts. */
  const pending = useRef<Promise<unknown>>(Promise.resolve());

  const reload = async (isDiscarded: boolean): Promise<void> => {
    const mine = ++newest.current;
    const answer = await readPlan();
    if (mine !== newest.current) return;
    setFailure(answer.ok ? null : answer.message);
    if (!answer.ok) return;
    const read = { missionId, plan: answer.value, revision };
    setDraft((before) => afterReading(before, read, isDiscarded));
  };
  useEffect(() => {
    // Depends on the draft as well: the plan of the mission may change while it is being read.
    const isCurrent = draft?.missionId === missionId && (isChanged || draft.revision === revision);
    if (missionId !== "" && isConnected && isReadable && !isCurrent) void reload(false);
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
    reload: () => void reload(true),
  };
}
