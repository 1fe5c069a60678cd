import { describe, expect, test } from "vitest";
import type { ImportedShape, Place, Plan, PlanReport } from "../src/api/types";
import { type Drawing, draftFeatures } from "../src/views/plan/draw_layer";
import { adviceOf, problemOf } from "../src/views/plan/problems";
import {
  midpoints,
  placesOf,
  proposedRoles,
  rolesFor,
  shapeNames,
  withImported,
  withNoGo,
  withoutShape,
  withPlaces,
} from "../src/views/plan/shapes";

const place = (latitude_deg: number, longitude_deg: number): Place => ({ latitude_deg, longitude_deg });
const TRIANGLE = [place(48, 14), place(48.001, 14), place(48, 14.001)];
const PLAN: Plan = {
  vehicles: 6,
  area: TRIANGLE,
  no_go: [],
  scan_heading_deg: 0,
  camera_fov_deg: 50,
  lowest_layer_m: 35,
  layer_spacing_m: 3,
  strategy: "aos-apso",
  strategy_parameters: {},
  fence_margin_m: 0,
  cruise_speed_mps: 10,
  battery_reserve_percent: 20,
  endurance_min: 25,
};
const drawing = (changes: Partial<Drawing> = {}): Drawing => ({
  plan: PLAN,
  legs: [],
  shape: "area",
  vertex: null,
  isDrawing: false,
  isEditable: true,
  ...changes,
});
const roles = (shown: Drawing): unknown[] => draftFeatures(shown).map((feature) => feature.properties?.["role"]);

describe("shapes of a plan", () => {
  test("are changed by their names, and nothing else with them", () => {
    const two = withNoGo(withNoGo(PLAN));
    const changed = withPlaces(two, "no_go[1]", TRIANGLE);
    expect(changed.no_go).toEqual([[], TRIANGLE]);
    expect(changed.area).toBe(PLAN.area);
    expect(shapeNames(changed)).toEqual(["area", "no_go[0]", "no_go[1]", "launch", "return_point", "fence"]);
    expect(withoutShape(changed, "no_go[0]").no_go).toEqual([TRIANGLE]);
  });
  test("a point has one place, the latest; removed, it is left to the service", () => {
    const launched = withPlaces(PLAN, "launch", TRIANGLE);
    expect(placesOf(launched, "launch")).toEqual([TRIANGLE[2]]);
    expect(withoutShape(launched, "launch").launch).toBeNull();
    expect(withPlaces(PLAN, "fence", []).fence).toBeNull();
  });
  test("corners can be put between all neighbours, also the last and the first", () => {
    expect(midpoints(TRIANGLE)).toHaveLength(3);
    expect(midpoints(TRIANGLE)[2]?.longitude_deg).toBeCloseTo(14.0005, 9);
    expect(midpoints(TRIANGLE.slice(0, 2))).toHaveLength(1);
    expect(midpoints(TRIANGLE.slice(0, 1))).toEqual([]);
  });
});

describe("on the map", () => {
  test("the chosen shape has handles, for observers none", () => {
    expect(roles(drawing())).toEqual(["area", "middle", "middle", "middle", "vertex", "vertex", "vertex"]);
    expect(roles(drawing({ isEditable: false }))).toEqual(["area"]);
  });
  test("two corners are a line until there is a third", () => {
    const [shape] = draftFeatures(drawing({ plan: withPlaces(PLAN, "area", TRIANGLE.slice(0, 2)) }));
    expect(shape?.geometry.type).toBe("LineString");
  });
});

describe("shapes of a file", () => {
  const shape = (role: ImportedShape["role"], places = TRIANGLE): ImportedShape => ({ role, name: "", places });

  test("of what a plan has one of, only the first is taken unasked", () => {
    expect(proposedRoles([shape("area"), shape("no_go"), shape("area"), shape("no_go")])).toEqual([
      "area",
      "no_go",
      "skip",
      "no_go",
    ]);
  });
  test("points cannot become areas, nor areas points", () => {
    expect(rolesFor(shape("launch", TRIANGLE.slice(0, 1)))).not.toContain("area");
    expect(rolesFor(shape("area"))).not.toContain("launch");
  });
  test("no-go areas are added, all others replace", () => {
    const before = withPlaces(withNoGo(PLAN), "no_go[0]", TRIANGLE);
    const other = TRIANGLE.map(({ latitude_deg, longitude_deg }) => place(latitude_deg + 1, longitude_deg));
    const home = shape("return", other.slice(0, 1));
    const after = withImported(
      before,
      [shape("area", other), shape("no_go", other), home],
      ["area", "no_go", "return"],
    );
    expect(after.area).toEqual(other);
    expect(after.no_go).toEqual([TRIANGLE, other]);
    expect(after.return_point).toEqual(other[0]);
    expect(withImported(before, [shape("area", other)], ["skip"])).toEqual(before);
  });
});

test("problems stand beside their own field, advice apart from them", () => {
  const report: PlanReport = {
    flyable: false,
    problems: [
      { field: "area", text: "Crosses itself.", blocking: true },
      { field: "layer_spacing_m", text: "Needs RTK.", blocking: false },
    ],
    proposals: [],
    estimate: null,
    layers_m: [],
  };
  expect(problemOf(report, "area")).toBe("Crosses itself.");
  expect(problemOf(report, "layer_spacing_m")).toBeUndefined();
  expect(adviceOf(report, "layer_spacing_m")).toBe("Needs RTK.");
  expect(problemOf(null, "area")).toBeUndefined();
});
