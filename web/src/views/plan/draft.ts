/** Draft of a mission's plan, and what becomes of it when the plan of the mission is read again. Pure functions. */
import type { Plan } from "../../api/types";
import { begun, type History } from "./history";

export interface Draft {
  readonly missionId: string;
  readonly history: History;
  /** Plan of the mission when it was read. */
  readonly flown: Plan;
  readonly revision: number;
}

export const isEdited = (draft: Draft | null): boolean => draft !== null && draft.history.plan !== draft.flown;

/** Draft after the plan has been read. Edits made while the station answered are kept, unless they were discarded. */
export function afterReading(
  before: Draft | null,
  { missionId, plan, revision }: { missionId: string; plan: Plan; revision: number },
  isDiscarded: boolean,
): Draft {
  if (before !== null && before.missionId === missionId && isEdited(before) && !isDiscarded) return before;
  return { missionId, history: begun(plan), flown: plan, revision };
}
