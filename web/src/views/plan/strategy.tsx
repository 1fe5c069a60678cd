/** Search strategy, with the parameters that it declares. */
import { useEffect, useState } from "preact/hooks";
import { readStrategies } from "../../api/plans";
import type { Plan, PlanReport, Strategy, StrategyParameter } from "../../api/types";
import { texts } from "../../texts";
import { NumberField } from "../../ui/number_field";
import {
  defaultText,
  parameterHint,
  parameterStep,
  parameterTitle,
  undeclaredParameters,
  withParameter,
} from "./parameters";
import { problemOf } from "./problems";

interface Props {
  plan: Plan;
  report: PlanReport | null;
  onChange(plan: Plan): void;
}

const fieldOf = (name: string): string => `strategy_parameters.${name}`;

export function StrategyFields({ plan, report, onChange }: Props) {
  const [strategies, setStrategies] = useState<readonly Strategy[]>([]);
  useEffect(() => {
    void readStrategies().then((answer) => answer.ok && setStrategies(answer.value));
  }, []);
  const names = strategies.map(({ name }) => name);
  const offered = names.includes(plan.strategy) ? names : [plan.strategy, ...names];
  const chosen = strategies.find(({ name }) => name === plan.strategy);
  return (
    <>
      <div class="number-field">
        <label for="plan-strategy">{texts.plan.strategy}</label>
        <select
          id="plan-strategy"
          data-testid="plan-strategy"
          value={plan.strategy}
          aria-describedby="plan-strategy-problem"
          onChange={({ currentTarget: { value } }) => {
            // Parameters of one strategy have no meaning for another.
            onChange({ ...plan, strategy: value, strategy_parameters: {} });
          }}
        >
          {offered.map((name) => (
            <option key={name} value={name}>
              {name}
            </option>
          ))}
        </select>
        <p id="plan-strategy-problem" class="is-bad field-problem">
          {problemOf(report, "strategy")}
        </p>
      </div>
      {chosen && <Parameters parameters={chosen.parameters} plan={plan} report={report} onChange={onChange} />}
    </>
  );
}

function Parameters({ parameters, plan, report, onChange }: Props & { parameters: readonly StrategyParameter[] }) {
  const [wanted, setOpen] = useState(false);
  const unknown = undeclaredParameters(plan, parameters);
  const isRefused = report?.problems.some(({ field }) => field.startsWith(fieldOf(""))) ?? false;
  const changed = Object.keys(plan.strategy_parameters).length;
  return (
    <details
      class="strategy-parameters"
      data-testid="strategy-parameters"
      open={wanted || isRefused}
      onToggle={({ currentTarget }) => setOpen(currentTarget.open)}
    >
      <summary>{texts.plan.strategyParameters(changed)}</summary>
      {unknown.map((name) => (
        <p key={name} class="is-bad" data-testid={`plan-${fieldOf(name)}-problem`}>
          {problemOf(report, fieldOf(name)) ?? `${name}: ${texts.plan.notOfStrategy}`}
          <button
            type="button"
            onClick={() => {
              const { [name]: _, ...others } = plan.strategy_parameters;
              onChange({ ...plan, strategy_parameters: others });
            }}
          >
            {texts.plan.remove}
          </button>
        </p>
      ))}
      {parameters.map((parameter) => (
        <ParameterField
          key={`${plan.strategy}-${parameter.name}`}
          parameter={parameter}
          plan={plan}
          report={report}
          onChange={onChange}
        />
      ))}
    </details>
  );
}

function ParameterField({ parameter, plan, report, onChange }: Props & { parameter: StrategyParameter }) {
  const { name, text, unit } = parameter;
  const id = `plan-${fieldOf(name)}`;
  const isChanged = name in plan.strategy_parameters;
  const value: unknown = isChanged ? plan.strategy_parameters[name] : parameter.default;
  const change = (to: unknown): void => onChange(withParameter(plan, parameter, to));
  const problem = problemOf(report, fieldOf(name));
  const explanation = (
    <>
      <p class="small">
        {text} {parameterHint(parameter)}
      </p>
      {isChanged && (
        <button
          type="button"
          data-testid={`reset-${name}`}
          aria-label={`${texts.plan.reset(defaultText(parameter))}, ${parameterTitle(parameter)}`}
          onClick={() => change(parameter.default)}
        >
          {texts.plan.reset(defaultText(parameter))}
        </button>
      )}
    </>
  );
  if (parameter.is_switch) {
    return (
      <div class="number-field">
        <label class="switch">
          <input
            type="checkbox"
            id={id}
            data-testid={id}
            checked={value === true}
            aria-describedby={`${id}-problem`}
            onChange={({ currentTarget: { checked } }) => change(checked)}
          />
          {parameterTitle(parameter)}
        </label>
        {problem && (
          <p id={`${id}-problem`} class="is-bad">
            {problem}
          </p>
        )}
        {explanation}
      </div>
    );
  }
  return (
    <NumberField
      id={id}
      label={parameterTitle(parameter)}
      unit={unit}
      decimals={4}
      step={parameterStep(parameter)}
      value={typeof value === "number" ? value : null}
      isOptional={parameter.is_optional}
      {...(parameter.is_optional ? { placeholder: texts.plan.off } : {})}
      {...(parameter.at_least === null ? {} : { min: parameter.at_least })}
      {...(parameter.at_most === null ? {} : { max: parameter.at_most })}
      problem={problem}
      onChange={change}
    >
      {explanation}
    </NumberField>
  );
}
