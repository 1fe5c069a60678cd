/** Data of the charts over time. Pure functions. */
import type { StepFigures } from "../../api/types";
import { displayName, quantity } from "../../format";
import type { Sample, VehicleSample } from "../../state/samples";
import { texts } from "../../texts";

type Column = readonly (number | null)[];

/** Token of the theme, or the colour of a vehicle. */
type Colour = { readonly token: string } | { readonly vehicleId: number };

export interface Series {
  readonly label: string;
  readonly colour: Colour;
  readonly values: Column;
  readonly isOnRight?: boolean;
  readonly isDashed?: boolean;
  readonly isFilled?: boolean;
  /** Whether a value holds until the next one. */
  readonly isStepped?: boolean;
}

export interface Axis {
  /** Value as shown in the legend. */
  format(value: number): string;
  /** Fixed ends; without them the axis begins at zero and reaches at least `least`. */
  readonly ends?: readonly [number, number];
  readonly least?: number;
  /** Values with ticks; by default chosen by the chart. */
  readonly splits?: readonly number[];
}

export interface Chart {
  readonly id: string;
  readonly title: string;
  /** Mission times, ascending. */
  readonly elapsed_s: readonly number[];
  readonly series: readonly Series[];
  readonly left: Axis;
  readonly right?: Axis;
}

/** States in the order in which a swarm goes through them. */
const STATES = ["jumping_out", "exploration", "exploitation", "convergence"] as const;

export const LINK_FIGURES = ["loss_percent", "roundTrip_ms", "age_s"] as const;
export type LinkFigure = (typeof LINK_FIGURES)[number];

/** Largest number of lines that can be distinguished. */
const LINKS_SHOWN = 8;

const unit =
  (decimals: number, name: string) =>
  (value: number): string =>
    quantity(value, decimals, name);

/** Charts of the steps, in the order of the page. */
export function stepCharts(steps: readonly StepFigures[]): Chart[] {
  const { series, title } = texts.understand;
  const elapsed_s = steps.map((step) => step.elapsed_s);
  const column = (read: (step: StepFigures) => number | null): Column => steps.map(read);
  return [
    {
      id: "visibility",
      title: title.visibility,
      elapsed_s,
      series: [
        {
          label: series.visibility,
          colour: { token: "--accent" },
          values: column((s) => s.visibility_m2),
          isFilled: true,
        },
        {
          label: series.threshold,
          colour: { token: "--warning" },
          values: column((s) => s.threshold_m2),
          isDashed: true,
        },
      ],
      // At least 1 m², so that noise before the first sighting looks like noise.
      left: { format: unit(2, "m²"), least: 1 },
    },
    {
      id: "swarm",
      title: title.swarm,
      elapsed_s,
      series: [
        { label: series.e_f, colour: { token: "--factor" }, values: column((s) => s.evolutionary_factor) },
        { label: series.c_s, colour: { token: "--accent" }, values: column((s) => s.c_s_m), isOnRight: true },
        { label: series.c_c, colour: { token: "--good" }, values: column((s) => s.c_c_m), isOnRight: true },
      ],
      left: { format: unit(2, ""), ends: [0, 1] },
      right: { format: unit(2, "m"), least: 1 },
    },
    {
      id: "state",
      title: title.state,
      elapsed_s,
      series: [{ label: series.state, colour: { token: "--factor" }, values: column(stateIndex), isStepped: true }],
      left: {
        format: (value) => displayName(texts.names.evolutionaryState, STATES[value] ?? ""),
        ends: [-0.3, STATES.length - 0.7],
        splits: STATES.map((_, index) => index),
      },
    },
    {
      id: "effort",
      title: title.effort,
      elapsed_s,
      series: [
        { label: series.work, colour: { token: "--accent" }, values: column((s) => s.work_ms), isFilled: true },
        { label: series.imaging, colour: { token: "--factor" }, values: column((s) => s.imaging_ms) },
        { label: series.lag, colour: { token: "--warning" }, values: column((s) => s.loop_lag_p99_ms), isDashed: true },
      ],
      left: { format: unit(0, "ms"), least: 10 },
    },
  ];
}

function stateIndex({ evolutionary_state }: StepFigures): number | null {
  const index = STATES.findIndex((state) => state === evolutionary_state);
  return index < 0 ? null : index;
}

/** Covered share of the search area. */
export function coverageChart(samples: readonly Sample[]): Chart {
  return {
    id: "coverage",
    title: texts.understand.title.coverage,
    elapsed_s: samples.map((sample) => sample.elapsed_s),
    series: [
      {
        label: texts.understand.series.covered,
        colour: { token: "--good" },
        values: samples.map((sample) => sample.covered_percent),
        isFilled: true,
      },
    ],
    left: { format: unit(0, "%"), ends: [0, 100] },
  };
}

/** One figure of the links of some vehicles. */
export function linkChart(samples: readonly Sample[], figure: LinkFigure, vehicleIds: readonly number[]): Chart {
  const formats = { loss_percent: unit(1, "%"), roundTrip_ms: unit(0, "ms"), age_s: unit(1, "s") };
  return {
    id: "links",
    title: texts.understand.title.links,
    elapsed_s: samples.map((sample) => sample.elapsed_s),
    series: vehicleIds.map((vehicleId) => ({
      label: String(vehicleId),
      colour: { vehicleId },
      values: samples.map(({ vehicles }) => vehicles.get(vehicleId)?.[figure] ?? null),
    })),
    left: { format: formats[figure], least: figure === "roundTrip_ms" ? 50 : 2 },
  };
}

/** Vehicles to show: the selected ones, otherwise those with the worst values now; ascending. */
export function linksToShow(
  links: ReadonlyMap<number, Pick<VehicleSample, LinkFigure>>,
  figure: LinkFigure,
  selected: ReadonlySet<number>,
): number[] {
  const badness = (id: number): number => links.get(id)?.[figure] ?? -1;
  const ids = [...links.keys()].filter((id) => selected.size === 0 || selected.has(id));
  const worst = ids.sort((a, b) => badness(b) - badness(a) || a - b).slice(0, LINKS_SHOWN);
  return worst.sort((a, b) => a - b);
}

/** Range from the first to the last time of all charts, or its latest part; null without data. */
export function timeRange(charts: readonly Chart[], latest_s: number | null): readonly [number, number] | null {
  const times = charts
    .flatMap(({ elapsed_s }) => [elapsed_s[0], elapsed_s.at(-1)])
    .filter((time) => time !== undefined);
  if (times.length === 0) return null;
  const [first_s, last_s] = [Math.min(...times), Math.max(...times)];
  const from_s = latest_s === null ? first_s : Math.max(first_s, last_s - latest_s);
  return [from_s, Math.max(last_s, from_s + 1)];
}
