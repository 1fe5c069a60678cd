import { describe, expect, test } from "vitest";
import { parseBounds } from "../src/api/viewer";
import { fitted, panned, pieces_m, scaleBar, toGround, toScreen, zoomed } from "../src/views/see/viewport";

const SIZE = { width_px: 800, height_px: 400 };
const VIEWPORT = { centre: [10, -20], metresPerPx: 0.05 } as const;

const close = (actual: readonly number[], expected: readonly number[]): void =>
  expected.forEach((value, index) => expect(actual[index]).toBeCloseTo(value, 9));

describe("viewport", () => {
  test("has north up and east to the right", () => {
    close(toScreen(VIEWPORT, SIZE, [10, -20]), [400, 200]);
    close(toScreen(VIEWPORT, SIZE, [11, -19]), [420, 180]);
  });
  test("leads from the screen back to the ground", () => {
    close(toGround(VIEWPORT, SIZE, toScreen(VIEWPORT, SIZE, [13.7, -25.2])), [13.7, -25.2]);
  });
  test("shows all of a box, whatever its shape", () => {
    const bounds = { west_m: -30, south_m: 5, east_m: 10, north_m: 65 };
    const viewport = fitted(bounds, SIZE);
    const [left, bottom] = toScreen(viewport, SIZE, [bounds.west_m, bounds.south_m]);
    const [right, top] = toScreen(viewport, SIZE, [bounds.east_m, bounds.north_m]);
    expect(Math.min(left, top)).toBeGreaterThan(0);
    expect(right).toBeLessThan(SIZE.width_px);
    expect(bottom).toBeLessThan(SIZE.height_px);
    expect(bottom - top).toBeGreaterThan(0.9 * SIZE.height_px);
  });
  test("follows a dragging finger", () => {
    const before = toGround(VIEWPORT, SIZE, [100, 100]);
    close(toGround(panned(VIEWPORT, [30, -40]), SIZE, [130, 60]), before);
  });
  test("zooms about the cursor", () => {
    const zoomedIn = zoomed(VIEWPORT, SIZE, 2, [650, 90]);
    expect(zoomedIn.metresPerPx).toBeCloseTo(0.025);
    close(toGround(zoomedIn, SIZE, [650, 90]), toGround(VIEWPORT, SIZE, [650, 90]));
  });
  test("has limits of its zoom", () => {
    expect(zoomed(VIEWPORT, SIZE, 1e9, [0, 0]).metresPerPx).toBeGreaterThan(0.001);
    expect(zoomed(VIEWPORT, SIZE, 1e-9, [0, 0]).metresPerPx).toBeLessThan(100);
  });
});

test.each([
  [0.05, 5],
  [0.012, 1],
  [0.03, 2],
  [1, 100],
])("a scale bar at %d m per pixel has %d m", (metresPerPx, length_m) => {
  const bar = scaleBar(metresPerPx, 120);
  expect(bar.length_m).toBeCloseTo(length_m);
  expect(bar.width_px).toBeCloseTo(length_m / metresPerPx);
});

test("measures piece by piece", () => {
  expect(
    pieces_m([
      [0, 0],
      [3, 4],
      [3, 10],
    ]),
  ).toEqual([5, 6]);
  expect(pieces_m([[1, 1]])).toEqual([]);
});

test("bounds of the header", () => {
  expect(parseBounds("-1.5,2,3,4.25")).toEqual({ west_m: -1.5, south_m: 2, east_m: 3, north_m: 4.25 });
  for (const broken of [null, "", "1,2,3", "1,2,3,x", "3,2,1,4", "1,2,3,4,5"]) expect(parseBounds(broken)).toBeNull();
});
