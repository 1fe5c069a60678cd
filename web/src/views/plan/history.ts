/** What was done to a plan, to be taken back and made again. Pure functions. */
import type { Plan } from "../../api/types";

export const MAX_STEPS = 100;
/** Changes of the same thing that follow one another faster are one gesture: a corner that is dragged, a number typed. */
export const GESTURE_MS = 1000;

export interface History {
  readonly past: readonly Plan[];
  readonly plan: Plan;
  /** What was taken back, the next one first. */
  readonly future: readonly Plan[];
  /** What the last change has touched, and when; null after it was taken back. */
  readonly gesture: { readonly touched: string; readonly at_ms: number } | null;
}

export const begun = (plan: Plan): History => ({ past: [], plan, future: [], gesture: null });

export function changed(before: History, plan: Plan, now_ms: number): History {
  const touched = touchedBy(before.plan, plan);
  const { gesture } = before;
  const goesOn = gesture !== null && gesture.touched === touched && now_ms - gesture.at_ms < GESTURE_MS;
  const past = goesOn ? before.past : [...before.past, before.plan].slice(-MAX_STEPS);
  return { past, plan, future: [], gesture: { touched, at_ms: now_ms } };
}

export function undone(before: History): History {
  const plan = before.past.at(-1);
  if (plan === undefined) return before;
  return { past: before.past.slice(0, -1), plan, future: [before.plan, ...before.future], gesture: null };
}

export function redone(before: History): History {
  const [plan, ...future] = before.future;
  if (plan === undefined) return before;
  return { past: [...before.past, before.plan], plan, future, gesture: null };
}

/** The fields that differ, with the number of corners: one more is another gesture, one that moves is not. */
function touchedBy(before: Plan, after: Plan): string {
  const names = Object.keys(after) as (keyof Plan)[];
  const fields = names.filter((name) => before[name] !== after[name]);
  return JSON.stringify([fields, cornersOf(before), cornersOf(after)]);
}

const cornersOf = ({ area, no_go, fence }: Plan): unknown[] =>
  [area, ...no_go, fence ?? []].map(({ length }) => length);
