/** List of the shapes of a plan: selects the one to edit and shows the problems of each. */
import type { Plan, PlanReport } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { adviceOf, problemOf } from "./problems";
import { isPoint, noGoIndex, placesOf, type ShapeName, shapeNames } from "./shapes";

/** Display name of a shape. */
export function shapeTitle(shape: ShapeName): string {
  const index = noGoIndex(shape);
  return index === null ? texts.plan.shape[shape as keyof typeof texts.plan.shape] : texts.plan.noGo(index + 1);
}

interface ListProps {
  plan: Plan;
  report: PlanReport | null;
  chosen: ShapeName;
  onChoose(shape: ShapeName): void;
  onAddNoGo(): void;
}

export function ShapeList({ plan, report, chosen, onChoose, onAddNoGo }: ListProps) {
  const { mayCommand } = useShell();
  return (
    <>
      <ul class="shape-list">
        {shapeNames(plan).map((shape) => (
          <li key={shape}>
            <button
              type="button"
              id={`plan-${shape}`}
              data-testid={`shape-${shape}`}
              aria-pressed={shape === chosen}
              aria-describedby={`shape-problem-${shape}`}
              onClick={() => onChoose(shape)}
            >
              <b>{shapeTitle(shape)}</b> <span class="small">{summary(shape, placesOf(plan, shape).length)}</span>
            </button>
            <p id={`shape-problem-${shape}`} class="is-bad field-problem" data-testid={`shape-problem-${shape}`}>
              {problemOf(report, shape)}
            </p>
            {adviceOf(report, shape) && <p class="is-warning field-problem">{adviceOf(report, shape)}</p>}
          </li>
        ))}
      </ul>
      {mayCommand && (
        <button
          type="button"
          id="plan-no_go"
          data-testid="add-no-go"
          aria-describedby="shape-problem-no_go"
          onClick={onAddNoGo}
        >
          {texts.plan.addNoGo}
        </button>
      )}
      <p id="shape-problem-no_go" class="is-bad field-problem" data-testid="shape-problem-no_go">
        {problemOf(report, "no_go")}
      </p>
    </>
  );
}

function summary(shape: ShapeName, count: number): string {
  if (count === 0) return texts.plan.notGiven[shape as keyof typeof texts.plan.notGiven] ?? texts.plan.empty;
  return isPoint(shape) ? texts.plan.given : texts.plan.corners(count);
}
