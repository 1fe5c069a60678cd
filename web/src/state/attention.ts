/** Vehicles that need an operator's attention, with the reasons. Pure functions. */
import type { Vehicle } from "../api/types";
import { age, gpsFix, quantity } from "../format";
import { said, texts } from "../texts";
import { isStale, linkAge_s } from "./freshness";

/** Ascending. */
const LEVELS = ["good", "warning", "critical"] as const;
export type Level = (typeof LEVELS)[number];

export interface Attention {
  readonly level: Level;
  /** Reasons in words, the worst first; none of a vehicle that is well. */
  readonly causes: readonly string[];
}

type Cause = readonly [Exclude<Level, "good">, string];

const LOW_BATTERY_PERCENT = 25;
export const HIGH_LOSS_PERCENT = 5;
/** MAVLink's GPS_FIX_TYPE of a position in three dimensions. */
const FIX_3D = 3;

export const isBatteryLow = ({ battery_percent: battery }: Vehicle): boolean =>
  battery !== null && battery < LOW_BATTERY_PERCENT;

/** Whether a vehicle flies as far as is known: its motors run and it does not say that it stands on the ground. */
export const isAirborne = ({ armed, landed }: Vehicle): boolean => armed === true && landed !== "on_ground";

/** Whether a vehicle has proved that it stands on the ground with its motors off. */
export const isGrounded = ({ armed, landed }: Vehicle): boolean => armed === false && landed === "on_ground";

export function attentionOf(vehicle: Vehicle, snapshotAge_s: number): Attention {
  const causes = [...linkCauses(vehicle, snapshotAge_s), ...ownCauses(vehicle, isStale(vehicle, snapshotAge_s))];
  const critical = causes.filter(([level]) => level === "critical");
  const sorted = [...critical, ...causes.filter(([level]) => level !== "critical")];
  return { level: sorted[0]?.[0] ?? "good", causes: sorted.map(([, words]) => words) };
}

/** Vehicles with the worst first, in their order where they are alike. */
export function worstFirst(levels: ReadonlyMap<number, Level>, ids: readonly number[]): number[] {
  const rank = (id: number): number => LEVELS.indexOf(levels.get(id) ?? "good");
  return ids.toSorted((a, b) => rank(b) - rank(a));
}

function linkCauses(vehicle: Vehicle, snapshotAge_s: number): Cause[] {
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  if (age_s === null) return vehicle.takes_part ? [["critical", texts.attention.neverHeard]] : [];
  if (!isStale(vehicle, snapshotAge_s)) return [];
  // Switched off after its flight, as most are.
  if (isGrounded(vehicle)) return vehicle.task === "landed" ? [] : [["warning", texts.attention.silent(age(age_s))]];
  return [["critical", texts.attention.silent(age(age_s))]];
}

/** What the vehicle itself reports; of one without contact only what was said about it, as its values are old. */
function ownCauses(vehicle: Vehicle, isOld: boolean): Cause[] {
  const { gps_fix: fix, packet_loss_percent: loss, refusal, text, battery_percent: battery, camera, task } = vehicle;
  const severity = isAirborne(vehicle) ? "critical" : "warning";
  const found: (Cause | false)[] = [
    !isOld && fix !== null && fix < FIX_3D && [severity, texts.attention.fix(gpsFix(fix))],
    !isOld && isBatteryLow(vehicle) && ["warning", texts.attention.battery(quantity(battery, 0, "%"))],
    refusal !== null && ["warning", refusal],
    text !== "" && ["warning", text],
    !isOld && loss !== null && loss > HIGH_LOSS_PERCENT && ["warning", texts.attention.loss(quantity(loss, 0, "%"))],
    task === "swarm" && !!camera?.failure && ["warning", texts.attention.camera(said(camera.failure))],
  ];
  return found.filter((cause) => cause !== false);
}
