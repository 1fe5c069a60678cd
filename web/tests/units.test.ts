import { afterEach, expect, test } from "vitest";
import { amount, dateAndTime, distance, quantity } from "../src/format";
import { chooseUnits, shownUnit } from "../src/units";
import { defaultText } from "../src/views/plan/parameters";

afterEach(() => chooseUnits("metric"));

const PARAMETER = { name: "c_1_m", text: "", unit: "m", default: 2, is_optional: false };

test("imperial units are those of the international foot, and what has no other unit stays", () => {
  expect(quantity(38, 0, "m")).toBe("38\u202fm");
  chooseUnits("imperial");
  expect(quantity(38, 0, "m")).toBe("125\u202fft");
  expect(quantity(0.4, 1, "m")).toBe("1.3\u202fft");
  expect(quantity(10, 1, "m/s")).toBe("22.4\u202fmph");
  expect(quantity(1, 2, "ha")).toBe("2.47\u202fac");
  expect(quantity(100, 0, "m²")).toBe("1076\u202fft²");
  expect(quantity(12, 0, "ha/h")).toBe("30\u202fac/h");
  expect(amount(10, 1, "m")).toBe("32.8");
  expect(quantity(84, 0, "%")).toBe("84\u202f%");
  expect(quantity(-0.01, 0, "m")).toBe("0\u202fft");
  expect(distance(3218.688)).toBe("2.00\u202fmi");
  expect(shownUnit("mi").factor).toBe(1);
});

test("defaults of parameters are told in the unit of their field", () => {
  const parameter = PARAMETER as Parameters<typeof defaultText>[0];
  expect(defaultText(parameter)).toBe("2\u202fm");
  chooseUnits("imperial");
  expect(defaultText(parameter)).toBe("6.562\u202fft");
});

test("a moment has its date and its zone", () => {
  expect(dateAndTime(0)).toMatch(/^19(70-01-01|69-12-31) \d\d:\d\d:\d\d \S+/);
});
