/** Number fields of the plan with suggested values: heading, pattern, strategy, limits, forest. */
import type { Plan, PlanProposal, PlanReport } from "../../api/types";
import { quantity } from "../../format";
import { useShell } from "../../shell/context";
import { said, texts } from "../../texts";
import { NumberField } from "../../ui/number_field";
import { Dial } from "./dial";
import { FOREST, HEADING, LIMITS, NEW_FOREST, type NumberName, type NumberRule, PATTERN, SWEEP } from "./fields";
import { adviceOf, problemOf } from "./problems";
import { StrategyFields } from "./strategy";

interface Props {
  plan: Plan;
  report: PlanReport | null;
  onChange(plan: Plan): void;
}

export function PatternFields({ plan, report, onChange }: Props) {
  const { mayCommand } = useShell();
  return (
    <>
      <div class="heading-field">
        {mayCommand && (
          <Dial heading_deg={plan.scan_heading_deg} onChange={(deg) => onChange({ ...plan, scan_heading_deg: deg })} />
        )}
        <PlanNumber name="scan_heading_deg" rule={HEADING} plan={plan} report={report} onChange={onChange} />
      </div>
      <div class="field-grid">
        {PATTERN.map(([name, rule]) => (
          <PlanNumber key={name} name={name} rule={rule} plan={plan} report={report} onChange={onChange} />
        ))}
      </div>
      <SweepFields plan={plan} report={report} onChange={onChange} />
      <StrategyFields plan={plan} report={report} onChange={onChange} />
      <ForestFields plan={plan} report={report} onChange={onChange} />
    </>
  );
}

/** How the swarm flies along its legs, and how fast. */
function SweepFields({ plan, report, onChange }: Props) {
  const isContinuous = plan.search_mode === "continuous";
  return (
    <>
      <label class="switch">
        <input
          type="checkbox"
          id="plan-search_mode"
          data-testid="plan-search_mode"
          checked={isContinuous}
          onChange={({ currentTarget: { checked } }) =>
            onChange({ ...plan, search_mode: checked ? "continuous" : "stops" })
          }
        />
        {texts.plan.withoutStops}
      </label>
      {isContinuous && (
        <>
          <div class="field-grid">
            {SWEEP.map(([name, rule]) => (
              <PlanNumber key={name} name={name} rule={rule} plan={plan} report={report} onChange={onChange} />
            ))}
          </div>
          <label class="switch">
            <input
              type="checkbox"
              id="plan-split"
              data-testid="plan-split"
              aria-describedby="plan-split-advice"
              checked={plan.split}
              onChange={({ currentTarget: { checked } }) => onChange({ ...plan, split: checked })}
            />
            {texts.plan.split}
          </label>
          <p class="small" id="plan-split-advice">
            {adviceOf(report, "split")}
          </p>
        </>
      )}
    </>
  );
}

export function LimitFields({ plan, report, onChange }: Props) {
  return (
    <div class="field-grid">
      {LIMITS.map(([name, rule]) => (
        <PlanNumber key={name} name={name} rule={rule} plan={plan} report={report} onChange={onChange} />
      ))}
    </div>
  );
}

function PlanNumber({ name, rule, plan, report, onChange }: Props & { name: NumberName; rule: NumberRule }) {
  const proposal = report?.proposals.find(({ field }) => field === name);
  const change = (value: number | null): void => onChange({ ...plan, [name]: value });
  const value = plan[name] ?? null;
  return (
    <NumberField
      {...rule}
      label={texts.plan.field[name]}
      id={`plan-${name}`}
      value={value}
      {...(rule.isOptional
        ? { placeholder: name === "pod_percent" ? texts.plan.notWanted : texts.plan.automatic }
        : {})}
      problem={problemOf(report, name)}
      advice={adviceOf(report, name)}
      onChange={change}
    >
      {proposal && <Proposal proposal={proposal} rule={rule} onTake={change} />}
      {name === "fence_margin_m" && value === null && report && (
        <p class="small" data-testid="fence-margin">
          {texts.plan.stoppingDistance(report.stopping_distance)}
        </p>
      )}
    </NumberField>
  );
}

function Proposal({
  proposal: { field, value, reason },
  rule: { decimals, unit },
  onTake,
}: {
  proposal: PlanProposal;
  rule: NumberRule;
  onTake(value: number): void;
}) {
  const rounded = Number(value.toFixed(decimals));
  return (
    <p class="proposal small" data-testid={`proposal-${field}`}>
      {texts.plan.proposed}: {said(reason)}
      <button type="button" data-testid={`take-${field}`} onClick={() => onTake(rounded)}>
        {texts.plan.take(quantity(rounded, decimals, unit))}
      </button>
    </p>
  );
}

/** Heights and density of the forest, which the station needs to suggest a spacing. */
function ForestFields({ plan, report, onChange }: Props) {
  const forest = plan.forest ?? null;
  return (
    <>
      <label class="switch">
        <input
          type="checkbox"
          id="plan-forest"
          data-testid="plan-forest"
          checked={forest !== null}
          onChange={({ currentTarget: { checked } }) => onChange({ ...plan, forest: checked ? NEW_FOREST : null })}
        />
        {texts.plan.forest}
      </label>
      {forest && (
        <div class="field-grid">
          {FOREST.map(([name, rule]) => (
            <NumberField
              key={name}
              {...rule}
              label={texts.plan.forestField[name]}
              id={`plan-${name}`}
              value={forest[name]}
              onChange={(value) => value !== null && onChange({ ...plan, forest: { ...forest, [name]: value } })}
            />
          ))}
        </div>
      )}
      <p class="is-bad field-problem">{problemOf(report, "forest")}</p>
    </>
  );
}
