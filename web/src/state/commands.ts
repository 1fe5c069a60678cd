/** Available actions with their scope and labels, and whether they need confirmation. */
import type { Action, Mission, Phase } from "../api/types";
import { quantity, ranges } from "../format";
import { texts } from "../texts";
import { isGrounded } from "./attention";

/** Actions that concern the whole mission, whatever is selected. */
const MISSION_WIDE: ReadonlySet<Action> = new Set<Action>(["start", "abort", "focus", "new_sortie"]);
/** Actions that mean nothing to a vehicle that stands on the ground with its motors off. A hold is never withheld. */
const OF_FLYING: ReadonlySet<Action> = new Set<Action>(["pause", "resume", "return", "land"]);
/** Actions that start motors, end the search or bring vehicles down need confirmation. Hold never does. */
const DANGEROUS: ReadonlySet<Action> = new Set<Action>(["start", "join", "ready", "return", "land", "abort"]);
/** Actions that vehicles have to be named for: people stand beside them. */
const OF_NAMED: ReadonlySet<Action> = new Set<Action>(["ready", "not_ready"]);

/** Phases in which the plan, and the vehicles that fly, can still be changed. */
export const BEFORE_START: ReadonlySet<Phase> = new Set<Phase>(["connect", "preflight", "ready"]);

export const needsConfirmation = (action: Action): boolean => DANGEROUS.has(action);

/** Action with its vehicles, fixed when it was requested: what is shown is what is sent. */
export interface Command {
  readonly action: Action;
  /** Null for all vehicles. */
  readonly vehicleIds: readonly number[] | null;
  /** Height for the action `focus`; null resets it to automatic. */
  readonly focalHeight_m?: number | null;
  /** Verb and scope, for example "Hold 3 of 10: 1, 4, 7". */
  readonly label: string;
}

/** Set the focal plane of the mission from its next step on, or reset it to automatic. */
export function makeFocusCommand(focalHeight_m: number | null): Command {
  const label = focalHeight_m === null ? texts.focus.leave : texts.focus.at(quantity(focalHeight_m, 1, "m"));
  return { action: "focus", vehicleIds: null, focalHeight_m, label };
}

/** Command that an action means with the current selection. */
export function makeCommand(action: Action, mission: Mission | null, selected: ReadonlySet<number>): Command {
  const vehicleIds = targets(action, selected);
  return { action, vehicleIds, label: `${texts.names.action[action]} ${scope(action, vehicleIds, mission)}` };
}

/** Vehicles of an action: the selected ones, or null for all. */
export function targets(action: Action, selected: ReadonlySet<number>): readonly number[] | null {
  if (MISSION_WIDE.has(action) || selected.size === 0) return null;
  return [...selected].sort((a, b) => a - b);
}

function scope(action: Action, vehicleIds: readonly number[] | null, mission: Mission | null): string {
  if (action === "start" && mission !== null) return texts.scope.vehicles(ranges(launching(mission)));
  if (MISSION_WIDE.has(action)) return texts.scope.mission;
  if (action === "join" && vehicleIds === null) return texts.scope.waiting;
  const fleet = mission?.vehicles.length ?? 0;
  return vehicleIds === null ? texts.scope.all(fleet) : texts.scope.some(vehicleIds, fleet);
}

/** Ids of the vehicles that a launch starts. */
const launching = ({ vehicles }: Mission): number[] =>
  vehicles.filter((one) => one.takes_part).map((one) => one.vehicle_id);

/** Whether an action is available now; the station decides. */
export function isOffered(action: Action, mission: Mission | null, selected: ReadonlySet<number>): boolean {
  if (mission === null) return false;
  if (OF_FLYING.has(action) && areGrounded(mission, selected)) return false;
  if (OF_NAMED.has(action) && !areGrounded(mission, selected)) return false;
  // A paused mission cannot be paused again as a whole, but single vehicles can be paused or resumed.
  const isPartial = targets(action, selected) !== null && action === "pause";
  return mission.allowed_actions.includes(action) || (isPartial && mission.allowed_actions.includes("resume"));
}

/** Whether vehicles are selected and all of them have landed. */
export function areGrounded({ vehicles }: Pick<Mission, "vehicles">, selected: ReadonlySet<number>): boolean {
  return selected.size > 0 && vehicles.every((one) => !selected.has(one.vehicle_id) || isGrounded(one));
}
