/** Contents of the form for strategy parameters, derived from the declaration of the strategy. Pure functions. */
import type { Plan, StrategyParameter } from "../../api/types";
import { capitalised } from "../../format";
import { texts } from "../../texts";
import { shownUnit } from "../../units";

/**
 * Title of a parameter. Several letters are a word, single ones symbols of a paper: "Min factor", but "Initial c_s
 * hat".
 */
export function parameterTitle({ name, unit }: StrategyParameter): string {
  const bare = unit === "" ? name : name.slice(0, name.lastIndexOf("_"));
  const title = bare.replace(/(?<=[a-z]{2})_|_(?=[a-z]{2})/g, " ");
  return /^[a-z]{2}/.test(title) ? capitalised(title) : title;
}

/** Bounds and default, such as "Above 0 and at most 1, default 0.3."; switches have no bounds. */
export function parameterHint(parameter: StrategyParameter): string {
  const words = Object.keys(texts.plan.bounds) as (keyof typeof texts.plan.bounds)[];
  const bounds = words.flatMap((word) => {
    const value = parameter[word];
    return value === null ? [] : [texts.plan.bound(texts.plan.bounds[word], inShownUnit(parameter, value))];
  });
  const parts = [texts.plan.and(bounds), texts.plan.byDefault(defaultText(parameter))].filter((part) => part !== "");
  const hint = parts.join(", ");
  return `${capitalised(hint)}.`;
}

export function defaultText({ default: value, unit }: StrategyParameter): string {
  if (value === null || value === false) return texts.plan.off;
  if (value === true) return texts.plan.on;
  if (typeof value !== "number" || unit === "") return String(value);
  return `${inShownUnit({ unit }, value)}\u202f${shownUnit(unit).unit}`;
}

const inShownUnit = ({ unit }: Pick<StrategyParameter, "unit">, value: number): number =>
  Number((value * shownUnit(unit).factor).toPrecision(4));

/** Increment of the arrow keys: smaller for small ranges. */
export const parameterStep = ({ at_most, below }: StrategyParameter): number =>
  (at_most ?? below ?? 2) <= 1 ? 0.05 : 0.1;

/** Plan with another value; a default value is left out. */
export function withParameter(plan: Plan, { name, default: byDefault }: StrategyParameter, value: unknown): Plan {
  const { [name]: _, ...others } = plan.strategy_parameters;
  return { ...plan, strategy_parameters: value === byDefault ? others : { ...others, [name]: value } };
}

/** Names of parameters in the plan that its strategy does not have, for example from another version. */
export const undeclaredParameters = (plan: Plan, parameters: readonly StrategyParameter[]): string[] =>
  Object.keys(plan.strategy_parameters).filter((name) => !parameters.some((parameter) => parameter.name === name));
