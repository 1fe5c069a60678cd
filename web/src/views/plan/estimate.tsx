/** Estimate of the plan, and the button that applies it to the mission. */
import { useState } from "preact/hooks";
import { applyPlan } from "../../api/plans";
import type { Phase, PlanEstimate, PlanProblem } from "../../api/types";
import { amount, duration, quantity } from "../../format";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import type { PlanEditor } from "./use_plan";

const BEFORE_START: readonly Phase[] = ["connect", "preflight", "ready"];

export function EstimatePanel({ editor, form }: { editor: PlanEditor; form: string }) {
  const { mayCommand } = useShell();
  const { report, checkFailure, isChecking } = editor;
  return (
    <Panel title={texts.plan.estimate} testId="plan-estimate" class="plan-estimate">
      <div aria-live="polite" class={isChecking ? "is-old" : ""} data-state={isChecking ? "checking" : "checked"}>
        {checkFailure !== null && <p class="is-bad">{checkFailure}</p>}
        {report?.estimate && <Figures estimate={report.estimate} layers_m={report.layers_m} />}
        {report && !report.flyable && <Blocked problems={report.problems.filter(({ blocking }) => blocking)} />}
      </div>
      {mayCommand ? <Apply editor={editor} form={form} /> : <p class="small">{texts.plan.readOnly}</p>}
    </Panel>
  );
}

function Blocked({ problems }: { problems: readonly PlanProblem[] }) {
  const [first] = problems;
  return (
    <div class="button-row">
      <p class="is-bad" data-testid="plan-blocked">
        {texts.plan.blocked(problems.length)}
      </p>
      {first && (
        <button
          type="button"
          data-testid="plan-show-problem"
          onClick={() => document.getElementById(`plan-${first.field}`)?.focus()}
        >
          {texts.plan.showProblem}
        </button>
      )}
    </div>
  );
}

function Figures({ estimate, layers_m }: { estimate: PlanEstimate; layers_m: readonly number[] }) {
  const [lowest, highest] = [Math.min(...layers_m), Math.max(...layers_m)];
  const figures: [string, string][] = [
    [texts.plan.flight, duration(estimate.flight_s)],
    [texts.plan.scan, duration(estimate.scan_s)],
    [texts.plan.searchRate, quantity(estimate.hectares_per_hour, 0, "ha/h")],
    [texts.plan.coverage, quantity(estimate.covered_percent, 0, "%")],
    ...detection(estimate),
    [texts.plan.battery, quantity(estimate.battery_percent, 0, "%")],
    [texts.plan.areaSize, quantity(estimate.free_area_m2 / 10_000, 2, "ha")],
    [texts.plan.legs, String(estimate.legs.length)],
    [texts.plan.climb, quantity(estimate.climb_m, 0, "m")],
    [texts.plan.swath, quantity(estimate.swath_m, 0, "m")],
    [texts.plan.layers, `${amount(lowest, 0, "m")} – ${quantity(highest, 0, "m")}`],
  ];
  return (
    <dl class="figures">
      {figures.map(([name, value]) => (
        <div key={name} title={name === texts.plan.detection ? texts.plan.detectionOf : undefined}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

/** Expected probability of detection, where the forest is known. */
function detection({ detection_percent: expected }: PlanEstimate): [string, string][] {
  if (!expected) return [];
  const shares = [expected.standing, expected.sitting].map((percent) => amount(percent, 0, "%"));
  return [[texts.plan.detection, `${shares.join(", ")}, ${quantity(expected.lying, 0, "%")}`]];
}

function Apply({ editor, form }: { editor: PlanEditor; form: string }) {
  const { state, isConnected } = useShell();
  const { plan, report, isChecking, isChanged, isOvertaken, canUndo, canRedo, undo, redo } = editor;
  const [answer, setAnswer] = useState<{ isDone: boolean; text: string } | null>(null);
  const phase = state.mission?.phase ?? "connect";
  const isLate = !BEFORE_START.includes(phase);
  const apply = async (): Promise<void> => {
    // The browser marks the field with the invalid number.
    const fields = document.getElementById(form);
    if (plan === null || !(fields instanceof HTMLFormElement) || !fields.reportValidity()) return;
    const taken = await applyPlan(plan);
    setAnswer(taken.ok ? { isDone: true, text: texts.plan.applied } : { isDone: false, text: taken.message });
    if (taken.ok) editor.applied(plan, taken.value);
  };
  return (
    <>
      <div class="button-row">
        <button
          type="button"
          class="primary"
          data-testid="plan-apply"
          disabled={isLate || !isConnected || isChecking || report?.flyable !== true}
          onClick={() => void apply()}
        >
          {texts.plan.apply}
        </button>
        <button type="button" data-testid="plan-undo" title={texts.plan.undoHint} disabled={!canUndo} onClick={undo}>
          {texts.plan.undo}
        </button>
        <button type="button" data-testid="plan-redo" title={texts.plan.redoHint} disabled={!canRedo} onClick={redo}>
          {texts.plan.redo}
        </button>
        {(isChanged || isOvertaken) && (
          <button type="button" data-testid="plan-reload" onClick={editor.discard}>
            {texts.plan.reload}
          </button>
        )}
      </div>
      {isLate && (
        <p class="small" data-testid="plan-late">
          {texts.plan.late}
        </p>
      )}
      {isOvertaken && isChanged && (
        <p class="is-warning" data-testid="plan-overtaken">
          {texts.plan.overtaken}
        </p>
      )}
      <p class={answer?.isDone ? "is-done" : "is-bad"} role="status" data-testid="plan-answer">
        {answer?.text}
      </p>
    </>
  );
}
