/** How visible the target is over time, with the threshold and the swarm's evolutionary factor. */
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Step } from "../../api/types";
import { duration, quantity, words } from "../../format";

import { curve } from "./curve";
import { texts } from "../../texts";
import type { Theme } from "../../theme";

const FONT = "11px system-ui, sans-serif";

function makeOptions(element: HTMLElement): uPlot.Options {
  const style = getComputedStyle(element);
  const colour = (name: string): string => style.getPropertyValue(name).trim();
  const axis = { stroke: colour("--text-dim"), font: FONT, ticks: { show: false } };
  const grid = { stroke: colour("--line"), width: 1 };
  return {
    width: element.clientWidth,
    height: element.clientHeight,
    cursor: { show: false },
    legend: { show: false },
    scales: {
      x: { time: false },
      // At least 1 m² high, so that the noise before the first sighting looks like noise.
      m2: { range: (_, __, highest) => [0, Math.max(1, (highest ?? 0) * 1.15)] },
      factor: { range: [0, 1] },
    },
    axes: [
      { ...axis, grid, size: 22, space: 60, values: (_, splits) => splits.map(duration) },
      { ...axis, grid, scale: "m2", size: 40, values: (_, splits) => splits.map((value) => quantity(value, 1)) },
      { ...axis, grid: { show: false }, scale: "factor", side: 1, size: 30 },
    ],
    series: [
      {},
      { scale: "m2", stroke: colour("--accent"), width: 2, fill: colour("--accent-faint"), points: { show: false } },
      { scale: "m2", stroke: colour("--warning"), width: 1, dash: [5, 4], points: { show: false } },
      { scale: "factor", stroke: colour("--factor"), width: 1.5, points: { show: true, size: 4 } },
    ],
  };
}

export function ChartPanel({ steps, theme }: { steps: readonly Step[]; theme: Theme }) {
  const container = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const last = steps.at(-1);
  const isEmpty = last === undefined;

  useEffect(() => {
    const element = container.current;
    if (!element) return undefined;
    const made = new uPlot(makeOptions(element), curve(steps), element);
    plot.current = made;
    const observer = new ResizeObserver(() =>
      made.setSize({ width: element.clientWidth, height: element.clientHeight }),
    );
    observer.observe(element);
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
    // Made again for another theme; new steps reach it through setData.
  }, [theme, isEmpty]);
  useEffect(() => plot.current?.setData(curve(steps)), [steps]);

  const visibility = quantity(last?.visibility_m2, 2, "m²");
  const threshold = quantity(last?.threshold_m2, 2, "m²");
  return (
    <section class="chart panel" aria-label={texts.chart.panel} data-testid="chart">
      <div class="panel-head">
        <h2>{texts.chart.panel}</h2>
        <strong class="series-visibility" data-testid="visibility" data-value={last?.visibility_m2 ?? ""}>
          {visibility}
        </strong>
        <span class="series-threshold">
          {texts.chart.threshold} {threshold}
        </span>
      </div>
      {isEmpty ? (
        <p class="empty">{texts.chart.none}</p>
      ) : (
        <div class="plot" ref={container} role="img" aria-label={texts.chart.aria(visibility, threshold)} />
      )}
      {last && (
        <p class="small" data-testid="evolution">
          {texts.chart.branch} <b>{last.branch}</b>
          {last.evolutionary_state && (
            <>
              {" · "}
              {texts.chart.state} <b>{words(last.evolutionary_state)}</b>
            </>
          )}
          {last.evolutionary_factor !== null && (
            <>
              {" · "}
              <span class="series-factor">
                {texts.chart.factor} <b>{quantity(last.evolutionary_factor, 2)}</b>
              </span>
            </>
          )}
        </p>
      )}
    </section>
  );
}
