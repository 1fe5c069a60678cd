import { expect, test } from "vitest";
import { age, duration, eastNorth, gpsFix, quantity, ranges } from "../src/format";

test("what was never reported is a dash, not a zero", () => {
  expect(quantity(null, 1, "m")).toBe("–");
  expect(quantity(Number.NaN, 1)).toBe("–");
  expect(quantity(0, 1, "m")).toBe("0.0\u202fm");
  expect(age(null)).toBe("–");
  expect(gpsFix(null)).toBe("–");
});

test("numbers that follow each other are a range", () => {
  expect(ranges([7, 2, 1, 3, 10])).toBe("1–3, 7, 10");
  expect(ranges([4])).toBe("4");
});

test("numbers have a true minus and no negative zero", () => {
  expect(quantity(-1.25, 1)).toBe("\u22121.3");
  expect(quantity(-0.01, 1)).toBe("0.0");
});

test("durations and ages", () => {
  expect([0, 61.9, 3725].map(duration)).toEqual(["00:00", "01:01", "1:02:05"]);
  expect([0.24, 59.6, 300, 7300, 200_000].map(age)).toEqual(
    ["0.2", "60", "5", "2", "2"].map((n, i) => `${n}\u202f${["s", "s", "min", "h", "d"][i]}`),
  );
  expect(age(Infinity)).toBe("–");
});

test("places", () => {
  expect(eastNorth(1, -2)).toBe("E 1.0\u202fm, N \u22122.0\u202fm");
});

test("fixes have names", () => {
  expect([1, 3, 6, 42].map(gpsFix)).toEqual(["no fix", "3D", "RTK", "42"]);
});
