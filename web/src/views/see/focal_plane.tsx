/** Panel for the height of the plane on which the frames of a step are integrated. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { ViewedStep } from "../../api/types";
import { findFocus } from "../../api/viewer";
import { quantity } from "../../format";
import { useShell } from "../../shell/context";
import type { EnuPoint } from "../../state/state";
import { said, texts } from "../../texts";
import { Panel } from "../../ui/panel";
import type { ShownIntegral } from "./use_integral";

const SLIDER_STEP_M = 0.1;
const AUTOFOCUS_HALF_WIDTH_M = 5;

interface Props {
  viewed: ViewedStep;
  /** Null for the plane of the mission. */
  height_m: number | null;
  shown: ShownIntegral | null;
  problem: string;
  /** Centre of the area for the autofocus; null before there is an image. */
  centre: EnuPoint | null;
  onHeight(height_m: number | null): void;
}

export function FocalPlane({ viewed, height_m, shown, problem, centre, onHeight }: Props) {
  const { isSurvey } = useShell();
  const [focused, setFocused] = useState("");
  const [isFocusing, setFocusing] = useState(false);
  useEffect(() => setFocused(""), [viewed.step]);
  const chosen_m = height_m ?? viewed.focal_height_m;
  const current = useRef({ step: viewed.step, height_m });
  current.current = { step: viewed.step, height_m };
  const autofocus = async (at: EnuPoint): Promise<void> => {
    const asked = current.current;
    setFocusing(true);
    const answer = await findFocus(viewed.step, at, AUTOFOCUS_HALF_WIDTH_M);
    setFocusing(false);
    const { step, height_m: now_m } = current.current;
    if (step !== asked.step) return;
    if (!answer.ok) setFocused(answer.message);
    else if (!answer.value.found) setFocused(texts.see.notFocused(said(answer.value.reason)));
    else {
      // Whoever has moved the slider meanwhile keeps the height.
      if (now_m === asked.height_m) onHeight(answer.value.height_m);
      setFocused(texts.see.focused(quantity(answer.value.height_m, 2, "m"), quantity(answer.value.sigma_m, 2, "m")));
    }
  };
  return (
    <Panel title={texts.see.focalPlane} testId="focal-plane" class="see-panel">
      <label class="see-height">
        <span>
          {texts.see.height} <b>{quantity(chosen_m, 1, "m")}</b>
        </span>
        <input
          type="range"
          min={viewed.min_height_m}
          max={viewed.max_height_m}
          step={SLIDER_STEP_M}
          value={chosen_m}
          aria-valuetext={quantity(chosen_m, 1, "m")}
          data-testid="height"
          onInput={(event) => onHeight(event.currentTarget.valueAsNumber)}
        />
      </label>
      <div class="see-buttons">
        <button
          type="button"
          data-testid="autofocus"
          disabled={isFocusing || centre === null}
          title={texts.see.autofocusHint}
          onClick={() => centre && void autofocus(centre)}
        >
          {isFocusing ? texts.see.focusing : texts.see.autofocus}
        </button>
        <button type="button" data-testid="own-plane" disabled={height_m === null} onClick={() => onHeight(null)}>
          {(isSurvey ? texts.survey.ground : texts.see.ownPlane)(quantity(viewed.focal_height_m, 1, "m"))}
        </button>
      </div>
      <p class="small" role="status" data-testid="focus-result">
        {focused}
      </p>
      {shown && (
        <dl class="see-facts">
          <dt>{texts.see.visibility}</dt>
          <dd data-testid="plane-visibility">{quantity(shown.visibility_m2, 2, "m²")}</dd>
          <dt>{texts.see.latency}</dt>
          <dd data-testid="latency">{quantity(shown.latency_ms, 0, "ms")}</dd>
        </dl>
      )}
      {problem !== "" && (
        <p class="is-bad" role="alert">
          {problem}
        </p>
      )}
    </Panel>
  );
}
