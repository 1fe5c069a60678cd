/** Notices that need attention, and their acknowledgements: the same on every screen. Pure functions. */
import type { Acknowledgement, Notice, Severity } from "../api/types";

export interface Alert {
  /** Key shared by all repetitions. */
  readonly key: string;
  readonly severity: Exclude<Severity, "info">;
  readonly text: string;
  /** Track of the target that it is about; null for anything else. */
  readonly trackId: number | null;
  /** Vehicles that report the same; none where it concerns the mission. */
  readonly vehicleIds: readonly number[];
  /** Number and time of the latest repetition. */
  readonly id: number;
  readonly utc_s: number;
  /** Numbers of the latest repetition of each vehicle: to acknowledge these is to acknowledge all. */
  readonly ids: readonly number[];
  /** Repetitions of the vehicle with the most. */
  readonly count: number;
}

/** Severities in ascending order. */
export const SEVERITIES = ["info", "warning", "news", "critical"] as const satisfies readonly Severity[];

const keyOf = ({ vehicle_id, text }: Notice): string => `${vehicle_id ?? ""} ${text}`;

/** Acknowledgement of each notice that has one: it covers earlier repetitions, but not later ones. */
export function acknowledgementByNotice(
  notices: readonly Notice[],
  acknowledgements: readonly Acknowledgement[],
): ReadonlyMap<number, Acknowledgement> {
  const given = new Map(acknowledgements.map((one) => [one.notice_id, one]));
  const latest = new Map<string, Acknowledgement>();
  const found = new Map<number, Acknowledgement>();
  for (const notice of notices.toReversed()) {
    const acknowledgement = given.get(notice.notice_id) ?? latest.get(keyOf(notice));
    if (acknowledgement === undefined) continue;
    latest.set(keyOf(notice), acknowledgement);
    found.set(notice.notice_id, acknowledgement);
  }
  return found;
}

/**
 * Open alerts, most severe and newest first: repetitions of one text are one alert with a count, and so is what several
 * vehicles report in the same words, whatever their numbers.
 */
export function openAlerts(notices: readonly Notice[], acknowledgements: readonly Acknowledgement[]): Alert[] {
  const alerts = new Map<string, Alert>();
  for (const { notice, count } of openNotices(notices, acknowledgements)) {
    const { notice_id: id, severity, text, vehicle_id: vehicleId, utc_s, track_id: trackId } = notice;
    if (severity === "info") continue;
    const key = `${vehicleId === null ? "mission" : "vehicles"} ${severity} ${causeOf(text)}`;
    const others = alerts.get(key);
    alerts.set(key, {
      key,
      severity,
      text: others === undefined ? text : sharedText(others.text, text),
      trackId,
      vehicleIds: [...new Set([...(others?.vehicleIds ?? []), ...(vehicleId === null ? [] : [vehicleId])])],
      id,
      utc_s,
      ids: [...(others?.ids ?? []), id],
      count: Math.max(others?.count ?? 0, count),
    });
  }
  const rank = ({ severity }: Alert): number => SEVERITIES.indexOf(severity);
  return [...alerts.values()].sort((a, b) => rank(b) - rank(a) || b.id - a.id);
}

const NUMBER = /\d+(?:\.\d+)?/g;
const RANGE = /(\d+(?:\.\d+)?)(?:–(\d+(?:\.\d+)?))?/g;

/** Text without its numbers: vehicles that report the same with other numbers have the same cause. */
const causeOf = (text: string): string => text.replaceAll(NUMBER, "#");

/** Text that says the same as both, with the ranges of their numbers: "battery at 21–24 %". */
export function sharedText(one: string, other: string): string {
  if (one === other) return one;
  const others = [...other.matchAll(NUMBER)].map(([number]) => number);
  let index = 0;
  return one.replaceAll(RANGE, (range, low: string, high: string | undefined) => {
    const number = others[index++];
    if (number === undefined) return range;
    const sorted = [low, high ?? low, number].sort((a, b) => Number(a) - Number(b));
    const [least, most] = [sorted[0], sorted.at(-1)];
    return Number(least) === Number(most) ? low : `${least}–${most}`;
  });
}

/** Latest repetition of each text of each vehicle that nobody has acknowledged, with their number, oldest first. */
function openNotices(
  notices: readonly Notice[],
  acknowledgements: readonly Acknowledgement[],
): { notice: Notice; count: number }[] {
  const acknowledged = acknowledgementByNotice(notices, acknowledgements);
  const open = new Map<string, { notice: Notice; count: number }>();
  for (const notice of notices) {
    if (notice.severity === "info" || acknowledged.has(notice.notice_id)) continue;
    const key = keyOf(notice);
    open.set(key, { notice, count: (open.get(key)?.count ?? 0) + 1 });
  }
  return [...open.values()].sort((a, b) => a.notice.notice_id - b.notice.notice_id);
}

/**
 * At most `capacity` notices, in their order. Information is dropped first, then what has been acknowledged or said
 * again, then warnings, and critical notices that nobody has acknowledged last; of the same rank the oldest first.
 */
export function noticesToKeep(
  notices: readonly Notice[],
  acknowledgements: readonly Acknowledgement[],
  capacity: number,
): readonly Notice[] {
  const excess = notices.length - capacity;
  if (excess <= 0) return notices;
  const open = new Set(openNotices(notices, acknowledgements).map(({ notice }) => notice.notice_id));
  const rank = ({ notice_id, severity }: Notice): number => {
    if (severity === "info") return 0;
    return open.has(notice_id) ? 1 + SEVERITIES.indexOf(severity) : 1;
  };
  const dropped = new Set([...notices].sort((a, b) => rank(a) - rank(b) || a.notice_id - b.notice_id).slice(0, excess));
  return notices.filter((notice) => !dropped.has(notice));
}
