/** How old is what the page knows. */
import type { Mission, Vehicle } from "../api/types";

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

/** The mission tells its state five times per second; a busy machine may be late by some of these. */
export const SILENT_AFTER_S = 1.5;

/** Whether a mission that should give signs of life gives none. One that is over, or a record, has none to give. */
export function isSilent(mission: Mission | null, snapshotAge_s: number): boolean {
  if (mission === null || mission.replay !== null || mission.phase === "done") return false;
  return snapshotAge_s > SILENT_AFTER_S;
}
