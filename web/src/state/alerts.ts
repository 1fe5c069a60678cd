/** Warnings and critical notices that nobody has acknowledged yet. Pure functions. */
import type { Notice, Severity } from "../api/types";

export interface Alert {
  /** The same for every repetition. */
  readonly key: string;
  readonly severity: Exclude<Severity, "info">;
  readonly text: string;
  readonly vehicleId: number | null;
  /** Mission time of the latest repetition. */
  readonly elapsed_s: number;
  readonly count: number;
}

/** Mission time up to which an alert was acknowledged, by key. */
export type Acknowledged = ReadonlyMap<string, number>;

/** Open alerts: critical ones first, newest first; repetitions of one text are one alert with a count. */
export function openAlerts(notices: readonly Notice[], acknowledged: Acknowledged): Alert[] {
  const open = new Map<string, Alert>();
  for (const { severity, text, vehicle_id: vehicleId, elapsed_s } of notices) {
    if (severity === "info") continue;
    const key = `${vehicleId ?? ""} ${text}`;
    if (elapsed_s <= (acknowledged.get(key) ?? -Infinity)) continue;
    open.set(key, { key, severity, text, vehicleId, elapsed_s, count: (open.get(key)?.count ?? 0) + 1 });
  }
  const rank = (alert: Alert): number => (alert.severity === "critical" ? 0 : 1);
  return [...open.values()].sort((a, b) => rank(a) - rank(b) || b.elapsed_s - a.elapsed_s);
}

/** Acknowledge these alerts; one that comes again later is open again. */
export function acknowledge(acknowledged: Acknowledged, alerts: readonly Alert[]): Acknowledged {
  return new Map([...acknowledged, ...alerts.map(({ key, elapsed_s }) => [key, elapsed_s] as const)]);
}
