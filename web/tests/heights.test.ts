import { describe, expect, it } from "vitest";
import { allHeights, heightWords } from "../src/state/heights";

const unknown = { height_above_ground_m: null, height_above_home_m: null, altitude_amsl_m: null };

describe("heights", () => {
  it("count from the ground where it is known, and from home otherwise", () => {
    const vehicle = { height_above_ground_m: 22.4, height_above_home_m: 35, altitude_amsl_m: 295 };
    expect(heightWords(vehicle)).toBe("22\u202fm AGL");
    expect(heightWords({ ...vehicle, height_above_ground_m: null })).toBe("35\u202fm home");
    expect(heightWords({ ...vehicle, height_above_ground_m: 9.96 })).toBe("10.0\u202fm AGL");
    expect(heightWords(unknown)).toBe("\u2013");
  });

  it("are told together, with what they count from", () => {
    expect(allHeights({ height_above_ground_m: 22.4, height_above_home_m: 35, altitude_amsl_m: 295 })).toBe(
      "22.4\u202fm above ground, 35.0\u202fm above home, 295.0\u202fm above sea level",
    );
    expect(allHeights({ ...unknown, height_above_home_m: 1 })).toBe("1.0\u202fm above home");
    expect(allHeights(unknown)).toBe("");
  });
});
