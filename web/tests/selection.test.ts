import { describe, expect, test } from "vitest";
import { extend, NO_SELECTION, retain, select, toggle, typeDigit, TYPING_PAUSE_MS } from "../src/state/selection";

const FLEET = [1, 2, 3, 7, 10, 12];
const ids = (selection: { ids: ReadonlySet<number> }): number[] => [...selection.ids].sort((a, b) => a - b);

test("a click toggles, shift extends from the last click in the table's order", () => {
  const one = toggle(NO_SELECTION, 2);
  expect(ids(extend(one, 10, FLEET))).toEqual([2, 3, 7, 10]);
  expect(ids(extend(toggle(one, 10), 3, FLEET))).toEqual([2, 3, 7, 10]);
  expect(ids(toggle(one, 2))).toEqual([]);
});

describe("digits", () => {
  const type = (digits: string, adds = false, pause_ms = 0, start = NO_SELECTION) =>
    [...digits].reduce((selection, digit, i) => typeDigit(selection, { digit, adds }, FLEET, i * pause_ms), start);

  test("select the vehicle with that number alone", () => {
    expect(ids(type("7", false, 0, select(NO_SELECTION, [1, 2])))).toEqual([7]);
  });
  test("in quick succession make one number", () => {
    expect(ids(type("12"))).toEqual([12]);
    expect(ids(type("12", false, TYPING_PAUSE_MS + 1))).toEqual([2]);
  });
  test("that no vehicle has begin anew or select nothing", () => {
    expect(ids(type("13"))).toEqual([3]);
    expect(ids(type("9", false, 0, select(NO_SELECTION, [1])))).toEqual([1]);
  });
  test("with shift are added, and a longer number replaces its own beginning", () => {
    expect(ids(type("12", true, 0, select(NO_SELECTION, [7])))).toEqual([7, 12]);
  });
});

test("vehicles that are gone are forgotten", () => {
  const selection = select(NO_SELECTION, [1, 2]);
  expect(ids(retain(selection, [2, 3]))).toEqual([2]);
  expect(retain(selection, FLEET)).toBe(selection);
});
