/** How old the values of a vehicle are. */
import type { Vehicle } from "../api/types";

/** A vehicle reports several times per second; after this its values are shown as old. */
export const STALE_AFTER_S = 3;

/** Seconds since the vehicle was heard: the age in the snapshot and the snapshot's own; null if never heard. */
export function linkAge_s(vehicle: Vehicle, snapshotAge_s: number): number | null {
  return vehicle.link_age_s === null ? null : vehicle.link_age_s + Math.max(0, snapshotAge_s);
}

export function isStale(vehicle: Vehicle, snapshotAge_s: number): boolean {
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  return age_s === null || age_s > STALE_AFTER_S;
}
