/** State of the mission over time, as far as this page has received it. Pure functions. */
import type { Mission, Vehicle } from "../api/types";
import { STALE_AFTER_S } from "./freshness";

/** Link, battery and height of one vehicle; null where a value is not known. */
export interface VehicleSample {
  readonly battery_percent: number | null;
  /** Above ground where an elevation model tells it, otherwise above home. */
  readonly height_m: number | null;
  readonly age_s: number | null;
  readonly loss_percent: number | null;
  readonly roundTrip_ms: number | null;
}

export interface Sample {
  readonly elapsed_s: number;
  readonly covered_percent: number | null;
  readonly vehicles: ReadonlyMap<number, VehicleSample>;
}

const SPACING_S = 1;
/** A quarter of an hour. */
const SAMPLES_KEPT = 900;

/**
 * Samples with the current state. The same list while the last sample is recent; before the start there is one sample.
 *
 * A pause without data leaves a gap, since the values in between are unknown.
 */
export function extendSamples(samples: readonly Sample[], mission: Mission, isAfterPause = false): readonly Sample[] {
  const last = samples.at(-1);
  if (last !== undefined && mission.elapsed_s < last.elapsed_s + SPACING_S) return samples;
  const { elapsed_s, covered_percent } = mission;
  const vehicles = new Map(mission.vehicles.map((vehicle) => [vehicle.vehicle_id, vehicleSample(vehicle)]));
  const gap: Sample[] =
    last !== undefined && isAfterPause
      ? [{ elapsed_s: (last.elapsed_s + elapsed_s) / 2, covered_percent: null, vehicles: new Map() }]
      : [];
  return [...samples, ...gap, { elapsed_s, covered_percent, vehicles }].slice(-SAMPLES_KEPT);
}

/** Sample of a vehicle. Without contact only the age is known: the other figures are outdated. */
function vehicleSample(vehicle: Vehicle): VehicleSample {
  const { link_age_s: age_s, packet_loss_percent, link, battery_percent } = vehicle;
  const isHeard = age_s !== null && age_s <= STALE_AFTER_S;
  return {
    age_s,
    battery_percent: isHeard ? battery_percent : null,
    height_m: isHeard ? (vehicle.height_above_ground_m ?? vehicle.height_above_home_m) : null,
    loss_percent: isHeard ? packet_loss_percent : null,
    roundTrip_ms: isHeard ? (link?.round_trip_ms ?? null) : null,
  };
}
