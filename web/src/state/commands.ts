/** Which actions are offered, for whom, in which words, and which of them ask first. */
import type { Action, Mission } from "../api/types";
import { quantity } from "../format";
import { texts } from "../texts";

/** These concern the whole mission, whatever is selected. */
const MISSION_WIDE: ReadonlySet<Action> = new Set<Action>(["start", "abort", "focus"]);
/** These start motors, end the search or bring vehicles down: they ask once. Hold never asks. */
const DANGEROUS: ReadonlySet<Action> = new Set<Action>(["start", "join", "return", "land", "abort"]);

export const asksFirst = (action: Action): boolean => DANGEROUS.has(action);

/** An action with its vehicles, fixed when it was asked for: what is shown is what is sent. */
export interface Command {
  readonly action: Action;
  /** Null for all. */
  readonly vehicleIds: readonly number[] | null;
  /** Of the action focus alone; null leaves the height to the program. */
  readonly focalHeight_m?: number | null;
  /** Verb and scope, for example "Hold 3 of 10: 1, 4, 7". */
  readonly label: string;
}

/** Have the mission integrate on another plane from now on, or leave that to the program again. */
export function makeFocusCommand(focalHeight_m: number | null): Command {
  const label = focalHeight_m === null ? texts.focus.leave : texts.focus.at(quantity(focalHeight_m, 1, "m"));
  return { action: "focus", vehicleIds: null, focalHeight_m, label };
}

/** The command that an action would be now. */
export function makeCommand(action: Action, mission: Mission | null, selected: ReadonlySet<number>): Command {
  const vehicleIds = targets(action, selected);
  return { action, vehicleIds, label: `${texts.names.action[action]} ${scope(action, vehicleIds, mission)}` };
}

/** The vehicles an action goes to: those selected, or null for all. */
export function targets(action: Action, selected: ReadonlySet<number>): readonly number[] | null {
  if (MISSION_WIDE.has(action) || selected.size === 0) return null;
  return [...selected].sort((a, b) => a - b);
}

function scope(action: Action, vehicleIds: readonly number[] | null, mission: Mission | null): string {
  if (MISSION_WIDE.has(action)) return texts.scope.mission;
  if (action === "join" && vehicleIds === null) return texts.scope.waiting;
  const fleet = mission?.vehicles.length ?? 0;
  return vehicleIds === null ? texts.scope.all(fleet) : texts.scope.some(vehicleIds, fleet);
}

/** Whether an action can be asked for now; the service has the last word. */
export function isOffered(action: Action, mission: Mission | null, selected: ReadonlySet<number>): boolean {
  if (mission === null) return false;
  // A paused mission has nothing more to pause as a whole, but single vehicles can still be resumed or paused.
  const isPartial = targets(action, selected) !== null && action === "pause";
  return mission.allowed_actions.includes(action) || (isPartial && mission.allowed_actions.includes("resume"));
}
