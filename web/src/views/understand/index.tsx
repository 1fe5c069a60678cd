/** View Understand: progress of the search over time, state of the swarm, and quality of the links. */
import { useMemo, useState } from "preact/hooks";
import type { StepFigures } from "../../api/types";
import { displayName, duration, quantity } from "../../format";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Panel } from "../../ui/panel";
import { coverageChart, LINK_FIGURES, type LinkFigure, linkChart, linksToShow, stepCharts, timeRange } from "./charts";
import { Plot, type TimeRange } from "./plot";
import { Sorties } from "./sorties";
import { LinkTable, StepTable } from "./tables";
import "./understand.css";

const LATEST_S = { all: null, five: 300, one: 60 } as const;
type Latest = keyof typeof LATEST_S;
const FORMS = ["curves", "table"] as const;

export function UnderstandView() {
  const { state, theme, selection, snapshotAge_s, isOperator } = useShell();
  const [latest, setLatest] = useState<Latest>("all");
  const [zoom, setZoom] = useState<TimeRange | null>(null);
  const [form, setForm] = useState<(typeof FORMS)[number]>("curves");
  const [figure, setFigure] = useState<LinkFigure>("loss_percent");
  const { steps, samples, mission } = state;
  const charts = useMemo(() => {
    const links = samples.at(-1)?.vehicles ?? new Map();
    const shown = linksToShow(links, figure, selection.ids);
    return [...stepCharts(steps), coverageChart(samples), linkChart(samples, figure, shown)];
  }, [steps, samples, figure, selection.ids]);
  const range = zoom ?? timeRange(charts, LATEST_S[latest]);

  return (
    <div class="understand">
      <div class="understand-head">
        <Headline step={steps.at(-1)} />
        {zoom && form === "curves" && (
          <button type="button" data-testid="zoom-out" onClick={() => setZoom(null)}>
            {texts.understand.zoomOut(duration(zoom[0]), duration(zoom[1]))}
          </button>
        )}
        {form === "curves" && (
          <Choice
            label={texts.understand.range}
            testId="range"
            values={Object.keys(LATEST_S) as Latest[]}
            chosen={zoom ? null : latest}
            labels={texts.understand.latest}
            onChoose={(chosen) => {
              setZoom(null);
              setLatest(chosen);
            }}
          />
        )}
        <Choice
          label={texts.understand.form}
          testId="form"
          values={FORMS}
          chosen={form}
          labels={texts.understand.forms}
          onChoose={setForm}
        />
      </div>
      {mission && state.capabilities.operation && <Sorties mission={mission} mayControl={isOperator} />}
      {form === "table" && mission ? (
        <div class="understand-tables">
          <StepTable steps={steps} />
          <LinkTable mission={mission} snapshotAge_s={snapshotAge_s} />
        </div>
      ) : (
        <div class="understand-charts">
          {charts.map((chart) => (
            <Panel
              key={chart.id}
              title={chart.title}
              testId={`chart-${chart.id}`}
              class="chart"
              aside={
                chart.id === "links" && (
                  <Choice
                    label={chart.title}
                    testId="links"
                    values={LINK_FIGURES}
                    chosen={figure}
                    labels={texts.understand.figure}
                    onChoose={setFigure}
                  />
                )
              }
            >
              {range && chart.elapsed_s.length > 0 && chart.series.length > 0 ? (
                <Plot chart={chart} range={range} theme={theme} onZoom={setZoom} />
              ) : (
                <p class="empty">{texts.understand.none}</p>
              )}
            </Panel>
          ))}
        </div>
      )}
    </div>
  );
}

/** Figures of the latest step. */
function Headline({ step }: { step: StepFigures | undefined }) {
  const { headline } = texts.understand;
  return (
    <p class="understand-now">
      {headline.visibility}{" "}
      <strong data-testid="visibility" data-value={step?.visibility_m2 ?? ""}>
        {quantity(step?.visibility_m2, 2, "m²")}
      </strong>
      {step && (
        <span class="small" data-testid="evolution">
          {headline.threshold} {quantity(step.threshold_m2, 2, "m²")} · {displayName(texts.names.branch, step.branch)}
          {step.evolutionary_state !== null &&
            ` · ${displayName(texts.names.evolutionaryState, step.evolutionary_state)}`}
          {step.evolutionary_factor !== null && ` · ${headline.factor} ${quantity(step.evolutionary_factor, 2)}`}
        </span>
      )}
    </p>
  );
}
