/** One chart. All charts share the cursor, and a time range can be selected by dragging. */
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { duration, UNKNOWN } from "../../format";
import { vehicleColour } from "../../map/palette";
import { texts } from "../../texts";
import type { Theme } from "../../theme";
import type { Axis, Chart, Series } from "./charts";
import { selectByFinger } from "./finger";

const FONT = "11px system-ui, sans-serif";
const STEPPED = uPlot.paths.stepped?.({ align: 1 });
/** Whole seconds, since the axis shows no fractions. */
const TIME_TICKS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400];
const SHARED_CURSOR = "mission-time";
/** A shorter drag counts as a click. */
const SHORTEST_DRAG_PX = 6;

export type TimeRange = readonly [from_s: number, to_s: number];

interface Props {
  chart: Chart;
  range: TimeRange;
  theme: Theme;
  /** Null for the whole time. */
  onZoom(range: TimeRange | null): void;
}

export function Plot({ chart, range, theme, onZoom }: Props) {
  const container = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const zoom = useRef(onZoom);
  zoom.current = onZoom;
  // The lines of a plot are fixed: other lines need another plot.
  const lines = [chart.title, ...chart.series.map((series) => series.label)].join("|");
  useEffect(() => {
    const element = container.current;
    if (!element) return undefined;
    const size = (): { width: number; height: number } => ({
      width: element.clientWidth,
      height: plotHeight_px(element),
    });
    const made = new uPlot({ ...makeOptions(element, chart, zoom), ...size() }, columnsOf(chart), element);
    plot.current = made;
    made.setSize(size());
    const observer = new ResizeObserver(() => made.setSize(size()));
    observer.observe(element);
    const stopFingers = selectByFinger(made);
    return () => {
      stopFingers();
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [theme, lines]);
  useEffect(() => {
    plot.current?.batch(() => {
      plot.current?.setData(columnsOf(chart), false);
      plot.current?.setScale("x", { min: range[0], max: range[1] });
    });
    // The legend follows the cursor, but not new values.
    plot.current?.setLegend({});
  }, [chart, range[0], range[1], theme, lines]);
  return <div class="plot" ref={container} role="img" aria-label={describe(chart)} data-testid={`plot-${chart.id}`} />;
}

/** Height of the curve itself above the legend. */
function plotHeight_px(element: HTMLElement): number {
  const legend = element.querySelector<HTMLElement>(".u-legend");
  return Math.max(60, element.clientHeight - (legend?.offsetHeight ?? 0));
}

const columnsOf = ({ elapsed_s, series }: Chart): uPlot.AlignedData =>
  [elapsed_s, ...series.map(({ values }) => values)] as uPlot.AlignedData;

function describe({ title, series, left, right }: Chart): string {
  const latest = series.map(({ label, values, isOnRight }) => {
    const value = values.at(-1) ?? null;
    return `${label} ${value === null ? texts.noData : ((isOnRight ? right : left) ?? left).format(value)}`;
  });
  return `${title}: ${latest.join(", ")}`;
}

function makeOptions(
  element: HTMLElement,
  chart: Chart,
  zoom: { current: Props["onZoom"] },
): Omit<uPlot.Options, "width" | "height"> {
  const style = getComputedStyle(element);
  const token = (name: string): string => style.getPropertyValue(name).trim();
  const axis = { stroke: token("--text-dim"), font: FONT, ticks: { show: false } };
  const grid = { stroke: token("--line"), width: 1 };
  const colourOf = ({ colour }: Series): string =>
    "token" in colour ? token(colour.token) : vehicleColour(colour.vehicleId);
  const { left, right, series } = chart;
  return {
    cursor: {
      sync: { key: SHARED_CURSOR },
      drag: { x: true, y: false, setScale: false },
      y: false,
      points: { size: 6 },
      bind: {
        dblclick: () => () => {
          zoom.current(null);
          return null;
        },
      },
    },
    legend: { live: true },
    scales: { x: { time: false }, left: { range: rangeOf(left) }, right: { range: rangeOf(right ?? left) } },
    axes: [
      { ...axis, grid, size: 22, space: 60, incrs: TIME_TICKS_S, values: (_, splits) => splits.map(duration) },
      { ...axis, grid, ...ticksOf(left), scale: "left" },
      ...(right ? [{ ...axis, grid: { show: false }, ...ticksOf(right), scale: "right", side: 1 as const }] : []),
    ],
    series: [
      {
        label: texts.understand.time,
        value: atCursor((time_s) => duration(time_s)),
      },
      ...series.map((one): uPlot.Series => ({
        label: one.label,
        scale: one.isOnRight ? "right" : "left",
        stroke: colourOf(one),
        width: 2,
        points: { show: one.values.length < 3, size: 5 },
        spanGaps: false,
        value: atCursor((value) => ((one.isOnRight ? right : left) ?? left).format(value)),
        ...(one.isStepped && STEPPED && { paths: STEPPED }),
        ...(one.isDashed && { dash: [5, 4] }),
        ...(one.isFilled && { fill: token("--accent-faint") }),
      })),
    ],
    hooks: {
      setSelect: [
        (made) => {
          const { left: from_px, width: width_px } = made.select;
          if (width_px < SHORTEST_DRAG_PX) return;
          const range: TimeRange = [made.posToVal(from_px, "x"), made.posToVal(from_px + width_px, "x")];
          made.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          zoom.current(range);
        },
      ],
    },
  };
}

/** Value in the legend: at the cursor, or the latest one without a cursor. */
const atCursor =
  (format: (value: number) => string): uPlot.Series.Value =>
  (made, value: number | null, line, index) => {
    const shown = index === null ? made.data[line]?.at(-1) : value;
    return typeof shown === "number" ? format(shown) : UNKNOWN;
  };

const rangeOf =
  ({ ends, least = 0 }: Axis) =>
  (_: uPlot, __: number | null, highest: number | null): uPlot.Range.MinMax =>
    ends ? [...ends] : [0, Math.max(least, (highest ?? 0) * 1.1)];

/**
 * Ticks of an axis. Named values need room for their names; numbers are shown without their unit, which the legend has.
 */
function ticksOf({ splits, format }: Axis): Partial<uPlot.Axis> {
  if (splits === undefined) return { size: 44 };
  return { size: 92, splits: [...splits], values: (_, values) => values.map(format) };
}
