/** Age of the data on the page. */
import type { Mission, Vehicle } from "../api/types";

/** A vehicle reports several times per second; after this time its values are marked as old. */
export const STALE_AFTER_S = 3;

/**
 * Seconds since the last message of the vehicle: its age in the snapshot plus that of the snapshot; null if there was
 * none.
 */
export function linkAge_s(vehicle: Vehicle, snapshotAge_s: number): number | null {
  return vehicle.link_age_s === null ? null : vehicle.link_age_s + Math.max(0, snapshotAge_s);
}

export function isStale(vehicle: Vehicle, snapshotAge_s: number): boolean {
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  return age_s === null || age_s > STALE_AFTER_S;
}

/** The mission reports its state five times per second; a busy machine may delay some reports. */
const SILENT_AFTER_S = 1.5;

/** Whether a mission that should report does not. A finished mission and a recording have nothing to report. */
export function isSilent(mission: Mission | null, snapshotAge_s: number): boolean {
  if (mission === null || mission.replay !== null || mission.phase === "done") return false;
  return snapshotAge_s > SILENT_AFTER_S;
}
