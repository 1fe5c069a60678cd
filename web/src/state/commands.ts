/** Which actions are offered, for whom, and which of them ask first. */
import type { Action, Mission } from "../api/types";

/** These concern the whole mission, whatever is selected. */
const MISSION_WIDE: ReadonlySet<Action> = new Set<Action>(["start", "abort"]);
/** These end the search or bring vehicles down: they ask once. Hold never asks. */
const DANGEROUS: ReadonlySet<Action> = new Set<Action>(["return", "land", "abort"]);

export const asksFirst = (action: Action): boolean => DANGEROUS.has(action);

/** The vehicles an action goes to: those selected, or null for all. */
export function targets(action: Action, selected: ReadonlySet<number>): readonly number[] | null {
  if (MISSION_WIDE.has(action) || selected.size === 0) return null;
  return [...selected].sort((a, b) => a - b);
}

/** Whether an action can be asked for now; the service has the last word. */
export function isOffered(action: Action, mission: Mission | null, selected: ReadonlySet<number>): boolean {
  if (mission === null) return false;
  // A paused mission has nothing more to pause as a whole, but single vehicles can still be resumed or paused.
  const isPartial = targets(action, selected) !== null && action === "pause";
  return mission.allowed_actions.includes(action) || (isPartial && mission.allowed_actions.includes("resume"));
}
