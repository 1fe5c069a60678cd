/** Undo history of a plan. Pure functions. */
import type { Plan } from "../../api/types";

export const MAX_STEPS = 100;
/** Longest pause between changes of the same fields that count as one gesture: a dragged corner, a typed number. */
export const GESTURE_MS = 1000;

export interface History {
  readonly past: readonly Plan[];
  readonly plan: Plan;
  /** Undone plans, the next one to redo first. */
  readonly future: readonly Plan[];
  /** Fields and time of the last change; null after an undo or redo. */
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

/** Fields that differ, with the numbers of corners: adding a corner begins another gesture, moving one does not. */
function touchedBy(before: Plan, after: Plan): string {
  const names = Object.keys(after) as (keyof Plan)[];
  const fields = names.filter((name) => before[name] !== after[name]);
  return JSON.stringify([fields, cornersOf(before), cornersOf(after)]);
}

const cornersOf = ({ area, no_go, fence }: Plan): unknown[] =>
  [area, ...no_go, fence ?? []].map(({ length }) => length);
