/** Panels for measuring distances and comparing images. */
import { amount, quantity } from "../../format";
import { useShell } from "../../shell/context";
import type { EnuPoint } from "../../state/state";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { pieces_m } from "./viewport";

interface MeasureProps {
  isMeasuring: boolean;
  measured: readonly EnuPoint[];
  onToggle(): void;
  onClear(): void;
}

export function Measure({ isMeasuring, measured, onToggle, onClear }: MeasureProps) {
  const pieces = pieces_m(measured);
  const total_m = pieces.reduce((sum, piece_m) => sum + piece_m, 0);
  return (
    <Panel title={texts.see.distances} testId="measure" class="see-panel">
      <div class="see-buttons">
        <button type="button" aria-pressed={isMeasuring} data-testid="measure-toggle" onClick={onToggle}>
          {texts.see.measure}
        </button>
        <button type="button" disabled={measured.length === 0} data-testid="measure-clear" onClick={onClear}>
          {texts.see.clear}
        </button>
      </div>
      {isMeasuring && <p class="small">{texts.see.measureHint}</p>}
      <p role="status" data-testid="measured" data-metres={pieces.length > 0 ? total_m : undefined}>
        {pieces.length > 0 && <b>{quantity(total_m, 2, "m")}</b>}
        {pieces.length > 1 && ` = ${pieces.map((piece_m) => amount(piece_m, 2, "m")).join(" + ")}`}
      </p>
    </Panel>
  );
}

interface CompareProps {
  isComparing: boolean;
  canCompare: boolean;
  swipe: number;
  onToggle(): void;
  onSwipe(swipe: number): void;
}

export function Compare({ isComparing, canCompare, swipe, onToggle, onSwipe }: CompareProps) {
  const { isSurvey } = useShell();
  return (
    <Panel title={texts.see.compare} testId="compare" class="see-panel">
      <div class="see-buttons">
        <button
          type="button"
          aria-pressed={isComparing}
          disabled={!canCompare && !isComparing}
          data-testid="compare-toggle"
          onClick={onToggle}
        >
          {texts.see.keepLeft}
        </button>
      </div>
      {isComparing ? (
        <label class="see-height">
          <span>{texts.see.swipe}</span>
          <input
            type="range"
            min={0}
            max={1}
            step={0.01}
            value={swipe}
            data-testid="swipe"
            onInput={(event) => onSwipe(event.currentTarget.valueAsNumber)}
          />
        </label>
      ) : (
        <p class="small">{isSurvey ? texts.survey.compareHint : texts.see.compareHint}</p>
      )}
    </Panel>
  );
}
