/** Findings as alerts and events point to them. Pure functions. */
import type { Finding } from "../api/types";
import type { Alert } from "./alerts";

/** Finding of a target's track, or the earlier one that it turned out to be; null while there is none. */
export function findingOfTrack(findings: readonly Finding[], trackId: number | null): Finding | null {
  if (trackId === null) return null;
  const found = findings.find(({ track_id }) => track_id === trackId);
  return findings.find(({ finding_id }) => finding_id === found?.merged_into) ?? found ?? null;
}

/** Finding of the first alert about one that nobody has decided on, but for those that were closed; null without. */
export function undecidedAlerted(
  alerts: readonly Pick<Alert, "trackId">[],
  findings: readonly Finding[],
  closed: ReadonlySet<number>,
): Finding | null {
  const found = alerts.map(({ trackId }) => findingOfTrack(findings, trackId));
  return found.find((one) => one?.status === "new" && !closed.has(one.finding_id)) ?? null;
}

/** Finding of the first alert that is about one; null without. */
export function alertedFinding(
  alerts: readonly Pick<Alert, "trackId">[],
  findings: readonly Finding[],
): Finding | null {
  return alerts.map(({ trackId }) => findingOfTrack(findings, trackId)).find((found) => found !== null) ?? null;
}
