/** What the service holds against a plan, by field. Pure functions. */
import type { PlanProblem, PlanReport } from "../../api/types";

const textsOf = (report: PlanReport | null, wanted: (problem: PlanProblem) => boolean): string | undefined =>
  report?.problems
    .filter(wanted)
    .map(({ text }) => text)
    .join(" ") || undefined;

/** What has to be mended about a field before the plan can be flown. */
export const problemOf = (report: PlanReport | null, field: string): string | undefined =>
  textsOf(report, (problem) => problem.field === field && problem.blocking);

/** What should be known about a field. */
export const adviceOf = (report: PlanReport | null, field: string): string | undefined =>
  textsOf(report, (problem) => problem.field === field && !problem.blocking);
