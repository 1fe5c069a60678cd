/** Selection of a step: the latest one, which is followed, or an earlier one. */
import { texts } from "../../texts";

interface Props {
  first: number;
  last: number;
  step: number;
  isFollowing: boolean;
  /** Null for the latest step. */
  onStep(step: number | null): void;
}

export function StepChoice({ first, last, step, isFollowing, onStep }: Props) {
  return (
    <div class="step-choice" role="group" aria-label={texts.see.steps}>
      <button
        type="button"
        aria-label={texts.see.stepBefore}
        disabled={step <= first}
        data-testid="step-before"
        onClick={() => onStep(step - 1)}
      >
        ‹
      </button>
      <input
        type="range"
        min={first}
        max={last}
        value={step}
        aria-label={texts.see.step}
        aria-valuetext={texts.see.stepOf(step, last)}
        data-testid="step-slider"
        onInput={(event) => onStep(event.currentTarget.valueAsNumber)}
      />
      <button
        type="button"
        aria-label={texts.see.stepAfter}
        disabled={step >= last}
        data-testid="step-after"
        onClick={() => onStep(step + 1)}
      >
        ›
      </button>
      <output>{texts.see.stepOf(step, last)}</output>
      <button type="button" aria-pressed={isFollowing} data-testid="step-latest" onClick={() => onStep(null)}>
        {texts.see.latest}
      </button>
    </div>
  );
}
