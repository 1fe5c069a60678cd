/** What the mission's state was over time, as far as this page has seen it. Pure. */
import type { Mission } from "../api/types";

/** How one vehicle was reached; null where it is not known. */
export interface LinkSample {
  readonly age_s: number | null;
  readonly loss_percent: number | null;
  readonly roundTrip_ms: number | null;
}

export interface Sample {
  readonly elapsed_s: number;
  readonly covered_percent: number | null;
  readonly links: ReadonlyMap<number, LinkSample>;
}

const SPACING_S = 1;
/** A quarter of an hour. */
const SAMPLES_KEPT = 900;

/** The same list when the last one is young. Before the start, where time stands still, there is one sample. */
export function extendSamples(samples: readonly Sample[], mission: Mission): readonly Sample[] {
  const last = samples.at(-1);
  if (last !== undefined && mission.elapsed_s < last.elapsed_s + SPACING_S) return samples;
  const links = mission.vehicles.map(({ vehicle_id, link_age_s, packet_loss_percent, link }): [number, LinkSample] => [
    vehicle_id,
    { age_s: link_age_s, loss_percent: packet_loss_percent, roundTrip_ms: link?.round_trip_ms ?? null },
  ]);
  const { elapsed_s, covered_percent } = mission;
  return [...samples, { elapsed_s, covered_percent, links: new Map(links) }].slice(-SAMPLES_KEPT);
}
