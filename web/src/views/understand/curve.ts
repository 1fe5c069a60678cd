/** The columns of the visibility curve. */
import type { Step } from "../../api/types";

type Column = (number | null)[];

/** Time, visibility, threshold and evolutionary factor of all steps; null where a step has no such value. */
export function curve(steps: readonly Step[]): [number[], Column, Column, Column] {
  return [
    steps.map((step) => step.elapsed_s),
    steps.map((step) => step.visibility_m2),
    steps.map((step) => step.threshold_m2),
    steps.map((step) => step.evolutionary_factor),
  ];
}
