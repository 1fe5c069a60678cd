/** Hook for the plan being edited: read from the mission, and checked by the station shortly after every change. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer } from "../../api/client";
import { untilAnswered } from "../../api/persistence";
import { checkPlan, readPlan } from "../../api/plans";
import type { Plan, PlanReport } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { afterApplying, afterDiscarding, isEdited, planDrafts } from "./draft";
import { changed, type History, redone, undone } from "./history";
import type { Undo } from "./use_undo_keys";

const CHECK_AFTER_MS = 400;
/** Delay after the station has refused a check because of too many requests. */
const CHECK_AGAIN_MS = 1500;
const TOO_MANY_REQUESTS = 429;

const drafts = planDrafts();

export interface PlanEditor extends Undo {
  /** Null until the plan has been read. */
  readonly plan: Plan | null;
  /** Reason why the plan cannot be read. */
  readonly failure: string | null;
  readonly isChanged: boolean;
  /** Whether the plan of the mission has changed, or may have, since the draft was based on it. */
  readonly isOvertaken: boolean;
  readonly report: PlanReport | null;
  /** Reason why the station could not check the plan. */
  readonly checkFailure: string | null;
  /** Whether the report belongs to an earlier state of the plan. */
  readonly isChecking: boolean;
  change(plan: Plan): void;
  /** Change the plan as it is by then, for what had to wait for the station. */
  edit(take: (plan: Plan) => Plan): void;
  /** Take note that the mission has got a plan. */
  applied(sent: Plan, applied: Plan): void;
  /** Discard the draft and read the plan of the mission again. */
  discard(): void;
}

export function usePlan(): PlanEditor {
  const { state, isConnected } = useShell();
  const missionId = state.mission?.mission_id ?? "";
  const hasOrigin = state.mission?.origin !== null;
  // Without an origin, places in metres cannot be converted to degrees; recordings have no plan to read.
  const isReadable = state.capabilities.planning && (hasOrigin || state.mission?.area.length === 0);
  const revision = state.planRevision;
  const [draft, setDraft] = useState(() => drafts.of(missionId));
  const [failure, setFailure] = useState<string | null>(null);
  const [checked, setChecked] = useState<{ plan: Plan; report: PlanReport | null; failure: string | null } | null>(
    null,
  );
  /** Pending check: one at a time, since only the latest plan counts. */
  const pending = useRef<Promise<unknown>>(Promise.resolve());

  useEffect(() => drafts.subscribe(setDraft), []);
  const isCurrent = draft?.missionId === missionId && draft.revision === revision;
  useEffect(() => {
    if (missionId === "" || !isConnected || !isReadable || isCurrent) return undefined;
    // The plan of the mission may change while it is being read: then it is read again.
    let isWanted = true;
    const read = async (): Promise<Answer<Plan>> => {
      const answer = await readPlan();
      if (isWanted) setFailure(answer.ok ? null : answer.message);
      return answer;
    };
    void untilAnswered(read, () => isWanted).then(
      (found) => found && drafts.read({ missionId, plan: found, revision }),
    );
    return () => {
      isWanted = false;
    };
  }, [missionId, isReadable, revision, isConnected, isCurrent]);

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
    drafts.change(missionId, (before) => ({ ...before, history: take(before.history) }));
  const edit = (take: (plan: Plan) => Plan): void =>
    step((before) => {
      const wanted = take(before.plan);
      return wanted === before.plan ? before : changed(before, wanted, performance.now());
    });
  return {
    plan,
    failure: state.capabilities.planning ? failure : texts.plan.notHere,
    isChanged: isEdited(draft),
    isOvertaken: draft !== null && (draft.isOvertaken || draft.revision !== revision),
    report: checked?.report ?? null,
    checkFailure: checked?.failure ?? null,
    isChecking: checked?.plan !== plan,
    canUndo: draft !== null && draft.history.past.length > 0,
    canRedo: draft !== null && draft.history.future.length > 0,
    undo: () => step(undone),
    redo: () => step(redone),
    change: (wanted) => edit(() => wanted),
    edit,
    applied: (sent, taken) => drafts.change(missionId, (before) => afterApplying(before, sent, taken)),
    discard: () => drafts.change(missionId, afterDiscarding),
  };
}
