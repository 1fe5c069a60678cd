/** What lies where in a replay, and what its keys mean. Pure functions. */
import type { Phase, ReplayRequest, Timeline } from "../api/types";

export const SPEEDS = [0.5, 1, 2, 4, 8, 16] as const;

const SKIP_S = 10;

export interface Span {
  readonly phase: Phase;
  readonly from_s: number;
  readonly to_s: number;
}

/** The phases with their ends; what lasts no time is left out, and a phase that goes on is one. */
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

/** When the step before or after a time was decided; null where there is none. */
export function neighbourStep_s({ steps }: Timeline, time_s: number, direction: 1 | -1): number | null {
  const times = steps.map((step) => step.time_s);
  // A replay that has been led to a step stands on it, apart from rounding.
  const found =
    direction === 1
      ? times.find((step_s) => step_s > time_s + 0.05)
      : times.findLast((step_s) => step_s < time_s - 0.05);
  return found ?? null;
}

/** The next faster or slower of the speeds. */
export function neighbourSpeed(speed: number, direction: 1 | -1): number {
  const found = direction === 1 ? SPEEDS.find((one) => one > speed) : SPEEDS.findLast((one) => one < speed);
  return found ?? speed;
}

/** What a key changes, or null where it means nothing here. */
export function keyChange(key: string, timeline: Timeline, now: Timeline["replay"]): ReplayRequest | null {
  const stepBefore_s = neighbourStep_s(timeline, now.time_s, -1);
  const stepAfter_s = neighbourStep_s(timeline, now.time_s, 1);
  switch (key) {
    case " ":
      return toggled(now);
    case "ArrowLeft":
      return { time_s: Math.max(0, now.time_s - SKIP_S) };
    case "ArrowRight":
      return { time_s: Math.min(now.duration_s, now.time_s + SKIP_S) };
    case ",":
      return stepBefore_s === null ? null : { time_s: stepBefore_s };
    case ".":
      return stepAfter_s === null ? null : { time_s: stepAfter_s };
    case "-":
      return { speed: neighbourSpeed(now.speed, -1) };
    case "+":
      return { speed: neighbourSpeed(now.speed, 1) };
    default:
      return null;
  }
}

/** Play or stop; at the end play begins anew. */
export function toggled({ playing, time_s, duration_s }: Timeline["replay"]): ReplayRequest {
  return playing || time_s < duration_s ? { playing: !playing } : { playing: true, time_s: 0 };
}
