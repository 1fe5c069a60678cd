import { describe, expect, test } from "vitest";
import type { Timeline } from "../src/api/types";
import {
  clustersOf,
  keyChange,
  marksOf,
  neighbour_s,
  neighbourSpeed,
  phaseSpans,
  toggled,
} from "../src/replay/timeline";

const TIMELINE: Timeline = {
  replay: { time_s: 12, duration_s: 60, speed: 1, playing: false },
  start_utc_s: 1.7e9,
  phases: [
    { time_s: 0, phase: "ready" },
    { time_s: 5, phase: "arm" },
    { time_s: 5, phase: "takeoff" },
    { time_s: 9, phase: "takeoff" },
    { time_s: 20, phase: "scan" },
  ],
  steps: [10, 12, 30].map((time_s, index) => ({ time_s, step: index + 1 })),
  notices: [
    { time_s: 3, severity: "info", text: "taking off", vehicle_id: null },
    { time_s: 13, severity: "critical", text: "link lost", vehicle_id: 2 },
    { time_s: 14, severity: "warning", text: "battery low", vehicle_id: 2 },
  ],
  findings: [{ time_s: 13.5, finding_id: 1, status: "confirmed" }],
};
const NOW = TIMELINE.replay;

test("phases end where the next one begins, the last one with the record", () => {
  expect(phaseSpans(TIMELINE).map(({ phase, from_s, to_s }) => [phase, from_s, to_s])).toEqual([
    ["ready", 0, 5],
    ["takeoff", 5, 20],
    ["scan", 20, 60],
  ]);
});

test("the steps before and after a time", () => {
  expect(neighbour_s(TIMELINE.steps, 12, -1)).toBe(10);
  expect(neighbour_s(TIMELINE.steps, 12, 1)).toBe(30);
  expect(neighbour_s(TIMELINE.steps, 10, -1)).toBeNull();
  expect(neighbour_s(TIMELINE.steps, 45, 1)).toBeNull();
});

test("notices and findings are marks in the order of their times", () => {
  expect(marksOf(TIMELINE).map(({ kind, text }) => [kind, text])).toEqual([
    ["info", "taking off"],
    ["critical", "Vehicle 2: link lost"],
    ["finding", "Finding 1 (confirmed)"],
    ["warning", "Vehicle 2: battery low"],
  ]);
});

test("marks that are close together are one, shown as what matters most", () => {
  const shown = (gap_s: number) => clustersOf(marksOf(TIMELINE), gap_s).map(({ kind, marks }) => [kind, marks.length]);
  expect(shown(0.1)).toEqual([
    ["info", 1],
    ["critical", 1],
    ["finding", 1],
    ["warning", 1],
  ]);
  expect(shown(2)).toEqual([
    ["info", 1],
    ["critical", 3],
  ]);
  expect(shown(60)).toEqual([["critical", 4]]);
  expect(clustersOf([], 2)).toEqual([]);
});

test("speeds have ends", () => {
  expect(neighbourSpeed(1, 1)).toBe(2);
  expect(neighbourSpeed(16, 1)).toBe(16);
  expect(neighbourSpeed(0.5, -1)).toBe(0.5);
});

test("play at the end begins anew", () => {
  expect(toggled(NOW)).toEqual({ playing: true });
  expect(toggled({ ...NOW, playing: true })).toEqual({ playing: false });
  expect(toggled({ ...NOW, time_s: 60 })).toEqual({ playing: true, time_s: 0 });
});

describe("keys", () => {
  test.each([
    [" ", { playing: true }],
    ["ArrowLeft", { time_s: 2 }],
    ["ArrowRight", { time_s: 22 }],
    [",", { time_s: 10 }],
    [".", { time_s: 30 }],
    ["[", { time_s: 3 }],
    ["]", { time_s: 13 }],
    ["+", { speed: 2 }],
    ["x", null],
  ])("'%s'", (key, change) => {
    expect(keyChange(key, TIMELINE, NOW)).toEqual(change);
  });
  test("stay within the record", () => {
    expect(keyChange("ArrowRight", TIMELINE, { ...NOW, time_s: 58 })).toEqual({ time_s: 60 });
    expect(keyChange("ArrowLeft", TIMELINE, { ...NOW, time_s: 3 })).toEqual({ time_s: 0 });
  });
});
