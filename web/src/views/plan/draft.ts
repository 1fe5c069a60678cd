/** Draft of a mission's plan, and what becomes of it when the plan of the mission is read again or applied. */
import type { Plan } from "../../api/types";
import { DraftKeeper } from "../../state/draft_keeper";
import { begun, type History } from "./history";

export interface Draft {
  readonly missionId: string;
  readonly history: History;
  /** Plan of the mission, as far as the draft is based on it. */
  readonly flown: Plan;
  /** Revision of the mission's plan that was read last. */
  readonly revision: number;
  /** Whether the mission had another plan than `flown` when it was read last. */
  readonly isOvertaken: boolean;
}

export interface Reading {
  readonly missionId: string;
  readonly plan: Plan;
  readonly revision: number;
}

/** Revision of no plan: it has to be read. */
const UNREAD = -1;

export const isEdited = (draft: Draft | null): boolean => draft !== null && draft.history.plan !== draft.flown;

const freshDraft = ({ missionId, plan, revision }: Reading): Draft => ({
  missionId,
  history: begun(plan),
  flown: plan,
  revision,
  isOvertaken: false,
});

/** Draft after the plan has been read. Edits are kept, also those made while the station answered. */
export function afterReading(before: Draft | null, read: Reading): Draft {
  if (before === null || before.missionId !== read.missionId) return freshDraft(read);
  const isOvertaken = !isSamePlan(before.flown, read.plan);
  if (isOvertaken && !isEdited(before)) return freshDraft(read);
  return { ...before, revision: read.revision, isOvertaken };
}

/** Draft after `sent` has become the plan of the mission. Edits made while the station answered are kept. */
export function afterApplying(before: Draft, sent: Plan, applied: Plan): Draft {
  const history = before.history.plan === sent ? begun(applied) : before.history;
  return { ...before, history, flown: applied, isOvertaken: false };
}

/** Draft without its edits; what the mission has instead is still to be read. */
export const afterDiscarding = (before: Draft): Draft => ({
  ...before,
  history: begun(before.flown),
  revision: UNREAD,
});

/** Both as the station sends them, with their fields in its order. */
const isSamePlan = (one: Plan, other: Plan): boolean => JSON.stringify(one) === JSON.stringify(other);

/** Keeper of one plan's draft. */
export const planDrafts = (): DraftKeeper<Draft, Reading> =>
  new DraftKeeper(({ missionId }) => missionId, afterReading);
