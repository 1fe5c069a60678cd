import { describe, expect, test } from "vitest";
import { boundsOf, circle, ellipse, gridLines, spacingOf, toEnu, toLngLat } from "../src/geometry";

const ORIGIN = { latitude_deg: 48.3358, longitude_deg: 14.3263, altitude_amsl_m: 262 };

describe("places on the globe", () => {
  test("agree with an exact conversion within centimetres", () => {
    // pymap3d.enu2geodetic(300, -400, 0, 48.3358, 14.3263, 262)
    const [lng, lat] = toLngLat(ORIGIN, [300, -400]);
    expect(lng).toBeCloseTo(14.33034596, 6);
    expect(lat).toBeCloseTo(48.332202851, 6);
  });
  test("come back", () => {
    const [east_m, north_m] = toEnu(ORIGIN, toLngLat(ORIGIN, [-123.4, 567.8]));
    expect(east_m).toBeCloseTo(-123.4, 6);
    expect(north_m).toBeCloseTo(567.8, 6);
  });
});

test("an ellipse reaches furthest along its heading", () => {
  const ring = ellipse([5, -3], { semi_major_m: 4, semi_minor_m: 1, heading_deg: 90 });
  const east = ring.map(([east_m]) => east_m);
  const north = ring.map(([, north_m]) => north_m);
  expect([Math.min(...east), Math.max(...east)].map(Math.round)).toEqual([1, 9]);
  expect([Math.min(...north), Math.max(...north)].map(Math.round)).toEqual([-4, -2]);
});
test("a circle is closed and has its radius", () => {
  const ring = circle([5, -3], 2);
  expect(ring.at(0)).toEqual(ring.at(-1));
  for (const [east_m, north_m] of ring) expect(Math.hypot(east_m - 5, north_m + 3)).toBeCloseTo(2, 9);
});

test("bounds enclose all points and the margin", () => {
  expect(boundsOf([[1, 2], [-3, 8]], 1)).toEqual({ west_m: -4, south_m: 1, east_m: 2, north_m: 9 }); // prettier-ignore
  expect(boundsOf([])).toBeNull();
});

test("grid lines lie at whole multiples, every fifth is a major one", () => {
  const lines = gridLines({ west_m: -12, south_m: -1, east_m: 52, north_m: 1 }, 10);
  const vertical = lines.filter((line) => line.from[0] === line.to[0]);
  expect(vertical.map((line) => line.from[0])).toEqual([-10, 0, 10, 20, 30, 40, 50]);
  expect(vertical.filter((line) => line.isMajor).map((line) => line.from[0])).toEqual([0, 50]);
});

test("the grid's spacings are round", () => {
  expect([0.1, 10, 11, 21, 51, 101, 499, 501].map(spacingOf)).toEqual([10, 10, 20, 50, 100, 200, 500, 1000]);
});
