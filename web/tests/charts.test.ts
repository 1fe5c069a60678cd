import { describe, expect, test } from "vitest";
import { extendSamples, type Sample } from "../src/state/samples";
import { coverageChart, linkChart, linksToShow, stepCharts, timeRange } from "../src/views/understand/charts";
import { figures, mission, vehicle } from "./samples";

const link = (round_trip_ms: number) => ({
  address: "",
  living_addresses: 1,
  round_trip_ms,
  clock_offset_ms: null,
  clock_drift_ppm: null,
});

test("charts of steps keep unknown values as gaps", () => {
  const [visibility, swarm, state] = stepCharts([
    figures(1, { visibility_m2: null }),
    figures(2, { evolutionary_factor: 0.4, evolutionary_state: "exploitation" }),
    figures(3, { evolutionary_state: "a state of the future" }),
  ]);
  expect(visibility?.elapsed_s).toEqual([2, 4, 6]);
  expect(visibility?.series[0]?.values).toEqual([null, 0.2, 0.3].map((value) => value && expect.closeTo(value)));
  expect(swarm?.series[0]?.values).toEqual([null, 0.4, null]);
  expect(state?.series[0]?.values).toEqual([null, 2, null]);
  expect(state?.left.format(2)).toBe("Exploitation");
});

describe("samples", () => {
  const at = (elapsed_s: number, changes = {}): Sample[] => [
    ...extendSamples([], mission({ elapsed_s, vehicles: [vehicle(1, { link: link(40), ...changes })] })),
  ];
  test("are a second apart", () => {
    const first = at(10);
    expect(extendSamples(first, mission({ elapsed_s: 10.9 }))).toBe(first);
    expect(extendSamples(first, mission({ elapsed_s: 11 }))).toHaveLength(2);
  });
  test("are not kept for ever", () => {
    let samples: readonly Sample[] = [];
    for (let elapsed_s = 0; elapsed_s < 1200; elapsed_s++) samples = extendSamples(samples, mission({ elapsed_s }));
    expect(samples).toHaveLength(900);
    expect(samples.at(-1)?.elapsed_s).toBe(1199);
  });
  test("have a gap where nothing was told", () => {
    const samples = extendSamples(at(1), mission({ elapsed_s: 61, vehicles: [vehicle(1, { link: link(40) })] }), true);
    const chart = linkChart(samples, "roundTrip_ms", [1]);
    expect(chart.elapsed_s).toEqual([1, 31, 61]);
    expect(chart.series[0]?.values).toEqual([40, null, 40]);
  });
  test("tell only the age of a vehicle that is silent", () => {
    const silent = { link_age_s: 9, packet_loss_percent: 1 };
    const [age, ...others] = (["age_s", "loss_percent", "roundTrip_ms"] as const).map(
      (figure) => linkChart(at(1, silent), figure, [1]).series[0]?.values,
    );
    expect(age).toEqual([9]);
    expect(others).toEqual([[null], [null]]);
  });
  test("tell of links, with gaps where a vehicle was not there", () => {
    const samples = [...at(1), ...at(2, { link: null }), ...at(3)];
    expect(linkChart(samples, "roundTrip_ms", [1]).series[0]?.values).toEqual([40, null, 40]);
    expect(linkChart(samples, "loss_percent", [2]).series[0]?.values).toEqual([null, null, null]);
    expect(coverageChart(samples).series[0]?.values).toEqual([null, null, null]);
  });
});

test("the links that are shown are those selected, else the worst", () => {
  const links = new Map(
    Array.from({ length: 20 }, (_, index) => [
      index + 1,
      { age_s: index === 4 ? null : 20 - index, loss_percent: index, roundTrip_ms: null },
    ]),
  );
  expect(linksToShow(links, "loss_percent", new Set())).toEqual([13, 14, 15, 16, 17, 18, 19, 20]);
  expect(linksToShow(links, "age_s", new Set())).toEqual([1, 2, 3, 4, 6, 7, 8, 9]);
  expect(linksToShow(links, "age_s", new Set([5, 9, 30]))).toEqual([5, 9]);
});

test("all charts show the same time", () => {
  const charts = [...stepCharts([figures(5), figures(300)]), linkChart([], "age_s", [])];
  expect(timeRange(charts, null)).toEqual([10, 600]);
  expect(timeRange(charts, 60)).toEqual([540, 600]);
  expect(timeRange(charts, 3600)).toEqual([10, 600]);
  expect(timeRange(stepCharts([figures(5)]), 60)).toEqual([10, 11]);
  expect(timeRange([linkChart([], "age_s", [])], null)).toBeNull();
});
