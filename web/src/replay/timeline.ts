/** Contents of the timeline of a replay, and the meaning of its keys. Pure functions. */
import type { Phase, ReplayRequest, Severity, Timeline } from "../api/types";
import { said, texts } from "../texts";

export const SPEEDS = [0.5, 1, 2, 4, 8, 16] as const;

const SKIP_S = 10;

export interface Span {
  readonly phase: Phase;
  readonly from_s: number;
  readonly to_s: number;
}

/** Notice or finding on the timeline. */
export interface Mark {
  readonly time_s: number;
  readonly kind: Severity | "finding";
  readonly text: string;
}

/** Marks that are too close together to be shown separately; at least one, oldest first. */
export interface Cluster {
  readonly marks: readonly [Mark, ...Mark[]];
  /** Kind of the most important mark. */
  readonly kind: Mark["kind"];
}

/** Kinds of marks, most important first. */
const BY_WEIGHT = ["critical", "finding", "news", "warning", "info"] as const;

/** Phases with their ends; repeated entries are merged and those without duration left out. */
export function phaseSpans({ phases, replay }: Timeline): Span[] {
  const starts = phases.filter(({ phase }, index) => phase !== phases[index - 1]?.phase);
  return starts
    .map(({ phase, time_s }, index): Span => ({
      phase,
      from_s: time_s,
      to_s: starts[index + 1]?.time_s ?? replay.duration_s,
    }))
    .filter(({ from_s, to_s }) => to_s > from_s);
}

/** Notices and findings in the order of their times. */
export function marksOf({ notices, findings }: Timeline): Mark[] {
  const { alerts, names, replay } = texts;
  const noticed = notices.map(({ time_s, severity: kind, text, vehicle_id: id }): Mark => {
    return { time_s, kind, text: id === null ? said(text) : alerts.vehicle(id, said(text)) };
  });
  const found = findings.map(({ time_s, finding_id: id, status }): Mark => {
    return { time_s, kind: "finding", text: replay.finding(id, names.finding[status]) };
  });
  return [...noticed, ...found].sort((a, b) => a.time_s - b.time_s);
}

/** Clusters of marks; a cluster spans less than the gap. */
export function clustersOf(marks: readonly Mark[], gap_s: number): Cluster[] {
  const groups: [Mark, ...Mark[]][] = [];
  for (const mark of marks) {
    const group = groups.at(-1);
    if (group !== undefined && mark.time_s - group[0].time_s < gap_s) group.push(mark);
    else groups.push([mark]);
  }
  const kindOf = (group: readonly Mark[]): Mark["kind"] =>
    BY_WEIGHT.find((kind) => group.some((mark) => mark.kind === kind)) ?? "info";
  return groups.map((group) => ({ marks: group, kind: kindOf(group) }));
}

/** Next moment after a time, or previous one before it; null if there is none. */
export function neighbour_s(moments: readonly { time_s: number }[], time_s: number, direction: 1 | -1): number | null {
  // A replay that was moved to a moment is at that moment, except for rounding.
  const found =
    direction === 1
      ? moments.find((moment) => moment.time_s > time_s + 0.05)
      : moments.findLast((moment) => moment.time_s < time_s - 0.05);
  return found?.time_s ?? null;
}

/** Next higher or lower speed. */
export function neighbourSpeed(speed: number, direction: 1 | -1): number {
  const found = direction === 1 ? SPEEDS.find((one) => one > speed) : SPEEDS.findLast((one) => one < speed);
  return found ?? speed;
}

/** Change that a key requests, or null for other keys. */
export function keyChange(key: string, timeline: Timeline, now: Timeline["replay"]): ReplayRequest | null {
  const leap = (moments: readonly { time_s: number }[], direction: 1 | -1): ReplayRequest | null => {
    const time_s = neighbour_s(moments, now.time_s, direction);
    return time_s === null ? null : { time_s };
  };
  switch (key) {
    case " ":
      return toggled(now);
    case "ArrowLeft":
      return { time_s: Math.max(0, now.time_s - SKIP_S) };
    case "ArrowRight":
      return { time_s: Math.min(now.duration_s, now.time_s + SKIP_S) };
    case ",":
      return leap(timeline.steps, -1);
    case ".":
      return leap(timeline.steps, 1);
    case "[":
      return leap(marksOf(timeline), -1);
    case "]":
      return leap(marksOf(timeline), 1);
    case "-":
      return { speed: neighbourSpeed(now.speed, -1) };
    case "+":
      return { speed: neighbourSpeed(now.speed, 1) };
    default:
      return null;
  }
}

/** Play or pause; at the end, play from the beginning. */
export function toggled({ playing, time_s, duration_s }: Timeline["replay"]): ReplayRequest {
  return playing || time_s < duration_s ? { playing: !playing } : { playing: true, time_s: 0 };
}
