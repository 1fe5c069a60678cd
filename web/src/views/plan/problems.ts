/** Problems of a plan that the station has reported, by field. Pure functions. */
import type { PlanProblem, PlanReport } from "../../api/types";
import { said } from "../../texts";

const textsOf = (report: PlanReport | null, wanted: (problem: PlanProblem) => boolean): string | undefined =>
  report?.problems
    .filter(wanted)
    .map(({ text }) => said(text))
    .join(" ") || undefined;

/** Problem of a field that prevents the plan from being applied. */
export const problemOf = (report: PlanReport | null, field: string): string | undefined =>
  textsOf(report, (problem) => problem.field === field && problem.blocking);

/** Advice about a field. */
export const adviceOf = (report: PlanReport | null, field: string): string | undefined =>
  textsOf(report, (problem) => problem.field === field && !problem.blocking);
