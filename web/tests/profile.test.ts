import { describe, expect, test } from "vitest";
import type { LegProfile } from "../src/api/types";
import { bandPath, clearanceOf, heightTicks, linePath, profileLines, scaleOf } from "../src/views/plan/profile_lines";

const PROFILE: LegProfile = {
  distance_m: [0, 50, 100],
  lowest_ground_m: [0, 5, 2],
  highest_ground_m: [1, 8, 3],
  surface_m: [0, 4, 0],
  floor_m: [31, 38, 33],
  ceiling_m: [120, 125, 122],
};
const LAYERS_M = [35, 38];
const SIZE = { width_px: 200, height_px: 100 };

describe("profile of a leg", () => {
  test("layers are offset from the surface that they follow, the canopy stands on the highest ground", () => {
    const lines = profileLines(PROFILE, LAYERS_M, 20);
    expect(lines.layers_m).toEqual([
      [35, 39, 35],
      [38, 42, 38],
    ]);
    expect(lines.canopy_m).toEqual([21, 28, 23]);
    expect(profileLines(PROFILE, LAYERS_M, null).canopy_m).toBeNull();
  });

  test("the clearance counts from the highest ground up to the lowest layer, and from the lowest to the highest", () => {
    expect(clearanceOf(profileLines(PROFILE, LAYERS_M, null))).toEqual({
      lowest_m: 31,
      highest_m: 38,
      isBelowFloor: false,
      isAboveCeiling: false,
    });
    const steep = { ...PROFILE, floor_m: [31, 39.1, 33], ceiling_m: [37, 125, 122] };
    expect(clearanceOf(profileLines(steep, LAYERS_M, null))).toMatchObject({
      isBelowFloor: true,
      isAboveCeiling: true,
    });
  });

  test("ground that is not known is a gap, and no clearance", () => {
    const nowhere = [null, null, null];
    const unknown = {
      ...PROFILE,
      lowest_ground_m: nowhere,
      highest_ground_m: nowhere,
      floor_m: nowhere,
      ceiling_m: nowhere,
    };
    expect(clearanceOf(profileLines(unknown, LAYERS_M, 20))).toEqual({
      lowest_m: null,
      highest_m: null,
      isBelowFloor: false,
      isAboveCeiling: false,
    });
    const scale = { ...SIZE, length_m: 100, bottom_m: 0, top_m: 100 };
    expect(linePath([0, 50, 75, 100], [10, null, 20, 30], scale)).toBe("M0.0,90.0M150.0,80.0L200.0,70.0");
    expect(bandPath([0, 50, 100], [0, null, 0], [10, 10, 10], scale)).toBe("");
    expect(bandPath([0, 100], [0, 0], [10, 20], scale)).toBe("M0.0,90.0L200.0,80.0L200.0,100.0L0.0,100.0Z");
  });

  test("all legs share the scale of heights, each has its own length", () => {
    const lines = profileLines(PROFILE, LAYERS_M, null);
    const deep = profileLines({ ...PROFILE, lowest_ground_m: [-40, 5, 2] }, LAYERS_M, null);
    const scale = scaleOf([lines, deep], lines, SIZE);
    expect(scale).toMatchObject({ ...SIZE, length_m: 100 });
    expect(scale.bottom_m).toBeLessThan(-40);
    expect(scale.top_m).toBeGreaterThan(125);
  });

  test("heights of the axis are round and not too many", () => {
    expect(heightTicks({ ...SIZE, length_m: 1, bottom_m: -5, top_m: 125 })).toEqual([0, 50, 100]);
    expect(heightTicks({ width_px: 200, height_px: 400, length_m: 1, bottom_m: 0, top_m: 125 })).toHaveLength(13);
  });
});
