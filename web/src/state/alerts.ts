/** Warnings and critical notices that nobody has acknowledged yet. Pure functions. */
import type { Severity } from "../api/types";
import type { NumberedNotice } from "./state";

export interface Alert {
  /** The same for every repetition. */
  readonly key: string;
  readonly severity: Exclude<Severity, "info">;
  readonly text: string;
  readonly vehicleId: number | null;
  /** Number and mission time of the latest repetition. */
  readonly id: number;
  readonly elapsed_s: number;
  readonly count: number;
}

/** Number of the repetition up to which an alert was acknowledged, by key. */
export type Acknowledged = ReadonlyMap<string, number>;

/** Open alerts: critical ones first, newest first; repetitions of one text are one alert with a count. */
export function openAlerts(notices: readonly NumberedNotice[], acknowledged: Acknowledged): Alert[] {
  const open = new Map<string, Alert>();
  for (const { id, severity, text, vehicle_id: vehicleId, elapsed_s } of notices) {
    if (severity === "info") continue;
    const key = `${vehicleId ?? ""} ${text}`;
    if (id <= (acknowledged.get(key) ?? 0)) continue;
    open.set(key, { key, severity, text, vehicleId, id, elapsed_s, count: (open.get(key)?.count ?? 0) + 1 });
  }
  const rank = (alert: Alert): number => (alert.severity === "critical" ? 0 : 1);
  return [...open.values()].sort((a, b) => rank(a) - rank(b) || b.id - a.id);
}

/** Acknowledge these alerts; one that comes again later is open again. */
export function acknowledge(acknowledged: Acknowledged, alerts: readonly Alert[]): Acknowledged {
  return new Map([...acknowledged, ...alerts.map(({ key, id }) => [key, id] as const)]);
}
