/** View See: images through the canopy, step by step, on any plane, and frame by frame. */
import { useEffect, useState } from "preact/hooks";
import type { Picture } from "../../api/types";
import type { IntegralQuery } from "../../api/viewer";
import { quantity } from "../../format";
import { boundsOf } from "../../geometry";
import { useShell } from "../../shell/context";
import type { EnuPoint, State } from "../../state/state";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { useResting } from "../../ui/pacing";
import { Panel } from "../../ui/panel";
import { FocalPlane } from "./focal_plane";
import { MissionPlane } from "./mission_plane";
import { Mosaic } from "./mosaic";
import { type Placed, Stage } from "./stage";
import { StepChoice } from "./step_choice";
import { Compare, Measure } from "./tools";
import { type ShownIntegral, useIntegral } from "./use_integral";
import { useViewedStep } from "./use_viewed_step";
import type { Viewport } from "./viewport";
import "./see.css";

/** A slider that has not moved for this long counts as released. */
const RESTING_MS = 300;

type Chosen = keyof typeof texts.see.kind;

const choices = (): Chosen[] => Object.keys(texts.see.kind) as Chosen[];

export function SeeView() {
  const { state, route, isSurvey } = useShell();
  const [kind, setKind] = useState<Chosen>("integral");
  const asked = Number(route.params["step"]) || null;
  const [chosenStep, setChosenStep] = useState(asked);
  const [height_m, setHeight] = useState<number | null>(null);
  const [viewport, setViewport] = useState<Viewport | null>(null);
  const [measured, setMeasured] = useState<readonly EnuPoint[]>([]);
  const [isMeasuring, setMeasuring] = useState(false);
  const [left, setLeft] = useState<IntegralQuery | null>(null);
  const [swipe, setSwipe] = useState(0.5);
  useEffect(() => {
    if (asked !== null) setChosenStep(asked);
  }, [asked]);

  const first = state.steps[0]?.step ?? null;
  const last = state.steps.at(-1)?.step ?? null;
  const step = last === null || first === null ? null : Math.max(first, Math.min(chosenStep ?? last, last));
  const answer = useViewedStep(state.capabilities.viewer ? step : null);
  const viewed = answer?.ok ? answer.value : null;
  const integralKind = viewed?.kinds.find((one) => one === kind) ?? null;
  const isDraft = !useResting(height_m, RESTING_MS);
  const query = step === null || integralKind === null ? null : { step, kind: integralKind, height_m, isDraft };
  const { shown, problem } = useIntegral(query);
  const { shown: before } = useIntegral(left);

  const latest = placedLatest(state, kind, isSurvey);
  // Steps without recorded frames show the images of the mission; so does the last step until its own are recorded.
  const own = integralKind === null ? null : shown && placedIntegral(shown, isSurvey);
  const picture = own ?? (integralKind === null || step === last ? latest : null);
  if (step === null || last === null || first === null) {
    return (
      <Panel title={texts.see.panel} testId="pictures" class="see-stage">
        <p class="empty">{texts.see.none}</p>
      </Panel>
    );
  }
  const centre: EnuPoint | null =
    viewport?.centre ??
    (shown && [(shown.bounds.west_m + shown.bounds.east_m) / 2, (shown.bounds.south_m + shown.bounds.north_m) / 2]);
  return (
    <>
      <Panel
        title={texts.see.panel}
        testId="pictures"
        class="see-stage"
        aside={
          <Choice
            label={texts.see.panel}
            testId="picture"
            values={choices()}
            chosen={kind}
            labels={texts.see.kind}
            onChoose={setKind}
          />
        }
      >
        <StepChoice first={first} last={last} step={step} isFollowing={chosenStep === null} onStep={setChosenStep} />
        {kind === "frames" ? (
          <Mosaic missionId={state.mission?.mission_id ?? ""} step={step} frames={viewed?.frames ?? []} />
        ) : (
          <Stage
            picture={picture}
            before={left && before && placedIntegral(before, isSurvey)}
            swipe={swipe}
            origin={state.mission?.origin ?? null}
            targets={state.mission?.targets ?? []}
            measured={measured}
            onMeasure={isMeasuring ? (point) => setMeasured((points) => [...points, point]) : null}
            viewport={viewport}
            onViewport={setViewport}
          >
            <button type="button" class="stage-fit" data-testid="fit" onClick={() => setViewport(null)}>
              {texts.see.fit}
            </button>
            {left && before && <span class="stage-left">{placedIntegral(before, isSurvey).label}</span>}
          </Stage>
        )}
      </Panel>
      {kind !== "frames" && (
        <div class="see-side">
          {viewed && integralKind !== null && (
            <FocalPlane {...{ viewed, height_m, shown, problem, centre }} onHeight={setHeight} />
          )}
          {answer?.ok === false && <p class="see-panel small">{answer.message}</p>}
          {!state.capabilities.viewer && <p class="see-panel small">{texts.see.noViewer}</p>}
          {!isSurvey && <MissionPlane viewed_m={viewed && (height_m ?? viewed.focal_height_m)} />}
          <Measure
            isMeasuring={isMeasuring}
            measured={measured}
            onToggle={() => setMeasuring(!isMeasuring)}
            onClear={() => setMeasured([])}
          />
          <Compare
            isComparing={left !== null}
            canCompare={shown !== null}
            swipe={swipe}
            onToggle={() => setLeft(left === null && shown ? queryOf(shown) : null)}
            onSwipe={setSwipe}
          />
        </div>
      )}
    </>
  );
}

const queryOf = ({ step, kind, height_m }: ShownIntegral): IntegralQuery => ({ step, kind, height_m, isDraft: false });

function placedIntegral({ url, bounds, step, kind, height_m }: ShownIntegral, isSurvey: boolean): Placed {
  const label = isSurvey ? texts.survey.label : texts.see.label;
  return { url, bounds, label: label(texts.see.kind[kind], step, quantity(height_m, 1, "m")) };
}

/** Latest image of this kind that the mission has made, if it makes any. */
function placedLatest({ pictures }: State, kind: Chosen, isSurvey: boolean): Placed | null {
  const label = isSurvey ? texts.survey.latestLabel : texts.see.latestLabel;
  const picture: Picture | undefined = kind === "frames" ? undefined : pictures[kind];
  const bounds = picture && boundsOf(picture.corners.map(({ east_m, north_m }) => [east_m, north_m]));
  if (!picture || !bounds) return null;
  return { url: picture.url, bounds, label: label(texts.see.kind[picture.kind], picture.step) };
}
