import { describe, expect, test } from "vitest";
import { keyCommand, type Stroke } from "../src/shell/keys";
import { parseRoute, routeHash, surveyRoute, VIEW_NAMES } from "../src/shell/route";

const stroke = (key: string, changes: Partial<Stroke> = {}): Stroke => ({
  key,
  code: /^\d$/.test(key) ? `Digit${key}` : `Key${key.toUpperCase()}`,
  shiftKey: false,
  altKey: false,
  ctrlKey: false,
  metaKey: false,
  repeat: false,
  ...changes,
});

describe("routes", () => {
  test("come back", () => {
    for (const view of VIEW_NAMES) expect(parseRoute(routeHash(view)).view).toBe(view);
    const params = { finding: "3", note: "a & b" };
    expect(parseRoute(routeHash("decide", params))).toEqual({ view: "decide", params });
  });
  test.each(["", "#", "#/", "#/nowhere", "#fly", "#/plan/x"])("'%s' leads to the default view", (hash) => {
    expect(parseRoute(hash)).toEqual({ view: "fly", params: {} });
  });
  test("a survey has no views of vehicles", () => {
    const shown = VIEW_NAMES.map((view) => surveyRoute({ view, params: { finding: "3" } }).view);
    expect(shown).toEqual(["decide", "decide", "decide", "see", "decide", "decide", "decide"]);
    expect(surveyRoute(parseRoute("#/decide?finding=3")).params).toEqual({ finding: "3" });
  });
});

describe("keys", () => {
  test("H holds everywhere, in text with Alt", () => {
    expect(keyCommand(stroke("h"), "page")).toEqual({ kind: "holdAll" });
    expect(keyCommand(stroke("H", { shiftKey: true }), "dialog")).toEqual({ kind: "holdAll" });
    expect(keyCommand(stroke("h"), "text")).toBeNull();
    expect(keyCommand(stroke("˙", { code: "KeyH", altKey: true }), "text")).toEqual({ kind: "holdAll" });
  });
  test("nothing else passes an open question, a text field, or a browser's own shortcut", () => {
    expect(keyCommand(stroke("f"), "dialog")).toBeNull();
    expect(keyCommand(stroke("1"), "text")).toBeNull();
    expect(keyCommand(stroke("a", { ctrlKey: true }), "page")).toBeNull();
    expect(keyCommand(stroke("h", { repeat: true }), "page")).toBeNull();
  });
  test("letters lead to views, digits to vehicles, also with shift on any layout", () => {
    expect(keyCommand(stroke("u"), "page")).toEqual({ kind: "view", view: "understand" });
    expect(keyCommand(stroke("7"), "page")).toEqual({ kind: "digit", digit: "7", adds: false });
    expect(keyCommand(stroke("/", { code: "Digit7", shiftKey: true }), "page")).toEqual({
      kind: "digit",
      digit: "7",
      adds: true,
    });
  });
  test("N shows the finding of an alert, but not while somebody types", () => {
    expect(keyCommand(stroke("n"), "page")).toEqual({ kind: "showFinding" });
    expect(keyCommand(stroke("n"), "text")).toBeNull();
  });
});
