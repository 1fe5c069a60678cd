import { describe, expect, test } from "vitest";
import type { ImportedShape, Place, Plan, PlanReport, StrategyParameter } from "../src/api/types";
import { type Drawing, draftFeatures } from "../src/views/plan/draw_layer";
import {
  afterApplying,
  afterDiscarding,
  afterReading,
  type Draft,
  isEdited,
  planDrafts,
} from "../src/views/plan/draft";
import { begun, changed, GESTURE_MS, type History, MAX_STEPS, redone, undone } from "../src/views/plan/history";
import { parameterHint, parameterTitle, undeclaredParameters, withParameter } from "../src/views/plan/parameters";
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
  passes: 1,
  split: false,
  layer_spacing_m: 3,
  strategy: "aos-apso",
  strategy_parameters: {},
  fence_margin_m: 0,
  cruise_speed_mps: 10,
  search_mode: "stops",
  search_speed_mps: 5,
  rate_hz: 2,
  battery_reserve_percent: 20,
  endurance_min: 25,
  search_min: 20,
};
const drawing = (changes: Partial<Drawing> = {}): Drawing => ({
  plan: PLAN,
  legs: [],
  shape: "area",
  vertex: null,
  isDrawing: false,
  leg: 0,
  fence: [],
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
  test("no-go zones are added, all others replace", () => {
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
    profile: [],
    canopy_height_m: null,
    fence: [],
    stopping_distance: "",
  };
  expect(problemOf(report, "area")).toBe("Crosses itself.");
  expect(problemOf(report, "layer_spacing_m")).toBeUndefined();
  expect(adviceOf(report, "layer_spacing_m")).toBe("Needs RTK.");
  expect(problemOf(null, "area")).toBeUndefined();
});

describe("undo", () => {
  const LATER_MS = 2 * GESTURE_MS;
  const withHeading = (plan: Plan, scan_heading_deg: number): Plan => ({ ...plan, scan_heading_deg });
  const moved = (plan: Plan, latitude_deg: number): Plan => ({
    ...plan,
    area: plan.area.map((corner, index) => (index === 0 ? { ...corner, latitude_deg } : corner)),
  });

  test("takes back what was done, in turn, and makes it again", () => {
    const [north, east] = [withHeading(PLAN, 10), withHeading(PLAN, 90)];
    let history = changed(changed(begun(PLAN), north, 0), east, LATER_MS);
    history = undone(history);
    expect(history.plan).toBe(north);
    history = undone(history);
    expect(history.plan).toBe(PLAN);
    expect(undone(history)).toBe(history);
    history = redone(redone(history));
    expect(history.plan).toBe(east);
    expect(redone(history)).toBe(history);
  });
  test("a corner that is dragged and a number that is typed are one step", () => {
    const drag = [48.1, 48.2, 48.3].reduce(
      (history, lat, i) => changed(history, moved(history.plan, lat), 50 * i),
      begun(PLAN),
    );
    expect(drag.past).toEqual([PLAN]);
    const pause = changed(drag, moved(drag.plan, 48.4), 100 + LATER_MS);
    expect(pause.past).toHaveLength(2);
  });
  test("every new corner is a step of its own, however fast they are set", () => {
    const add = (plan: Plan): Plan => ({ ...plan, area: [...plan.area, place(48.5, 14)] });
    const history = changed(changed(begun(PLAN), add(PLAN), 0), add(add(PLAN)), 10);
    expect(history.past).toHaveLength(2);
  });
  test("different fields are different steps, and so is a change after an undo", () => {
    const turned = changed(begun(PLAN), withHeading(PLAN, 10), 0);
    expect(changed(turned, { ...turned.plan, vehicles: 7 }, 10).past).toHaveLength(2);
    const back = undone(turned);
    expect(changed(back, withHeading(PLAN, 20), 20).past).toEqual([PLAN]);
    expect(changed(back, withHeading(PLAN, 20), 20).future).toEqual([]);
  });
  test("is bounded", () => {
    let history: History = begun(PLAN);
    for (let i = 1; i <= MAX_STEPS + 20; i++) history = changed(history, withHeading(PLAN, i), i * LATER_MS);
    expect(history.past).toHaveLength(MAX_STEPS);
    expect(history.past[0]?.scan_heading_deg).toBe(20);
  });
});

describe("parameters of the strategy", () => {
  const parameter = (changes: Partial<StrategyParameter>): StrategyParameter => ({
    name: "c5",
    text: "",
    unit: "",
    default: 0.3,
    is_switch: false,
    is_optional: false,
    above: null,
    at_least: null,
    below: null,
    at_most: null,
    ...changes,
  });

  test("have titles in words, symbols as in the paper, without the unit", () => {
    expect(parameterTitle(parameter({ name: "repulsion_cutoff_m", unit: "m" }))).toBe("Repulsion cutoff");
    expect(parameterTitle(parameter({ name: "initial_c_s_hat" }))).toBe("Initial c_s hat");
    expect(parameterTitle(parameter({ name: "c_s_m", unit: "m" }))).toBe("c_s");
  });
  test("tell their bounds and default", () => {
    expect(parameterHint(parameter({ above: 0, at_most: 1 }))).toBe("Above 0 and at most 1, default 0.3.");
    expect(parameterHint(parameter({ is_switch: true, default: true }))).toBe("Default on.");
    expect(parameterHint(parameter({ unit: "m", default: 2, at_least: 0 }))).toBe("At least 0, default 2\u202fm.");
  });
  test("stand in the plan only where they differ from the strategy's own", () => {
    const changed = withParameter(PLAN, parameter({}), 0.5);
    expect(changed.strategy_parameters).toEqual({ c5: 0.5 });
    expect(withParameter(changed, parameter({}), 0.3).strategy_parameters).toEqual({});
    expect(undeclaredParameters(changed, [])).toEqual(["c5"]);
    expect(undeclaredParameters(changed, [parameter({})])).toEqual([]);
  });
});

describe("draft of a plan while the station answers", () => {
  const read = { missionId: "a", plan: { ...PLAN, vehicles: 9 }, revision: 2 };
  const same = { ...read, plan: structuredClone(PLAN) };
  const fresh: Draft = { missionId: "a", history: begun(PLAN), flown: PLAN, revision: 1, isOvertaken: false };
  const withPasses = (before: Draft, passes: number): Draft => ({
    ...before,
    history: changed(before.history, { ...before.history.plan, passes }, 0),
  });
  const edited = withPasses(fresh, 2);

  test("is replaced by another plan of the mission where nobody has edited it", () => {
    expect(afterReading(null, read).history.plan).toBe(read.plan);
    expect(afterReading(fresh, read)).toMatchObject({ flown: read.plan, revision: 2, isOvertaken: false });
    expect(isEdited(afterReading(fresh, read))).toBe(false);
    expect(afterReading(edited, { ...read, missionId: "b" }).history.plan).toBe(read.plan);
  });

  test("keeps edits, and says that it is overtaken only by another plan", () => {
    expect(afterReading(edited, read)).toEqual({ ...edited, revision: 2, isOvertaken: true });
    expect(afterReading(edited, same)).toEqual({ ...edited, revision: 2 });
    expect(afterReading({ ...edited, isOvertaken: true }, same).isOvertaken).toBe(false);
  });

  test("keeps what has been undone where the plan is read again and is the same", () => {
    const undoneAll = { ...edited, history: undone(edited.history) };
    expect(afterReading(undoneAll, same).history.future).toEqual([edited.history.plan]);
  });

  test("keeps edits made while a plan is being applied, as edits of that plan", () => {
    const sent = edited.history.plan;
    const taken = structuredClone(sent);
    expect(isEdited(afterApplying(edited, sent, taken))).toBe(false);
    const later = afterApplying(withPasses(edited, 3), sent, taken);
    expect(later).toMatchObject({ flown: taken, isOvertaken: false });
    expect(later.history.plan.passes).toBe(3);
    expect(isEdited(later)).toBe(true);
  });

  test("loses its edits where they are discarded, keeps later ones, and has to be read again", () => {
    const discarded = afterDiscarding(edited);
    expect(discarded.history).toEqual(begun(PLAN));
    expect(discarded.revision).not.toBe(edited.revision);
    expect(afterReading(withPasses(discarded, 4), read).history.plan.passes).toBe(4);
    expect(afterReading(discarded, read).history.plan).toBe(read.plan);
  });

  test("changes by answers that come while another view is open, and not for another mission", () => {
    const keeper = planDrafts();
    keeper.read({ ...read, plan: PLAN });
    const late = (before: Draft): Draft => withPasses(before, 5);
    keeper.change("a", late);
    expect(keeper.of("a")?.history.plan.passes).toBe(5);
    const shown: (Draft | null)[] = [];
    const leave = keeper.subscribe((draft) => shown.push(draft));
    keeper.change("b", late);
    keeper.change("a", afterDiscarding);
    leave();
    keeper.change("a", late);
    expect(shown.map((draft) => draft?.history.plan.passes)).toEqual([5, PLAN.passes]);
    expect(keeper.of("b")).toBeNull();
    keeper.change("a", late);
    expect(keeper.of("a")).toBeNull();
  });
});
