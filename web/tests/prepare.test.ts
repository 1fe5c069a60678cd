import { expect, test } from "vitest";
import type { PreflightCheck } from "../src/api/types";
import {
  areChecksRows,
  blockersOf,
  cellStatusOf,
  matrixOf,
  subjectOf,
  withoutConfirmation,
} from "../src/views/prepare/checks";
import { confirmedIds, isProposal, proposedIds } from "../src/views/prepare/vehicles";

const check = (vehicle_id: number, name: string, changes: Partial<PreflightCheck> = {}): PreflightCheck => ({
  vehicle_id,
  name,
  status: "pass",
  text: "",
  remedy: "",
  overridable: false,
  overridden: null,
  blocks: false,
  ...changes,
});

test("one row per vehicle, the mission's checks beside; a check that a vehicle lacks leaves a hole", () => {
  const checks = [check(2, "link"), check(2, "battery"), check(1, "link"), check(0, "area")];
  const { mission, names, rows } = matrixOf(checks);
  expect(mission.map((one) => one.name)).toEqual(["area"]);
  expect(names).toEqual(["link", "battery"]);
  expect(rows.map((row) => row.id)).toEqual([1, 2]);
  expect(rows[0]?.checks.map((one) => one?.name)).toEqual(["link", undefined]);
});

test("an override does not make a failed check look passed", () => {
  const overridden = { reason: "known", by: "Ada", utc_s: 0 };
  expect(cellStatusOf(check(1, "link", { status: "fail", overridden }))).toBe("overridden");
  expect(cellStatusOf(check(1, "link", { status: "warn" }))).toBe("warn");
});

test("an issue that blocks the launch of several vehicles is listed once", () => {
  const checks = [
    check(1, "link", { blocks: true, text: "silent" }),
    check(2, "link", { blocks: true, text: "silent" }),
    check(3, "link", { blocks: true, text: "never heard" }),
    check(4, "link"),
  ];
  const blockers = blockersOf(checks);
  expect(blockers.map(({ ids, text }) => [subjectOf(...ids), text])).toEqual([
    ["Vehicles 1–2", "silent"],
    ["Vehicle 3", "never heard"],
  ]);
  expect(blockers[0]?.key).toBe("1 link");
});

const heard = (vehicle_id: number, changes: { takes_part?: boolean; armed?: boolean } = {}) => ({
  vehicle_id,
  takes_part: false,
  armed: false,
  ...changes,
});

test("as many vehicles as planned are proposed, none that runs its motors", () => {
  const vehicles = [heard(7), heard(2), heard(1, { armed: true }), heard(4), heard(9)];
  expect(proposedIds(vehicles, 3)).toEqual([2, 4, 7]);
});

test("vehicles confirmed already are the proposal", () => {
  const vehicles = [heard(7, { takes_part: true }), heard(2), heard(4, { takes_part: true })];
  expect(confirmedIds(vehicles)).toEqual([4, 7]);
  expect(proposedIds(vehicles, 3)).toEqual([4, 7]);
});

test("what only waits for the confirmation of the vehicles, or concerns others, is left out before it", () => {
  const checks = [
    check(0, "vehicles", { blocks: true }),
    check(0, "area", { blocks: true }),
    check(1, "geofence", { blocks: true }),
    check(2, "battery", { blocks: true }),
    check(3, "battery", { blocks: true }),
  ];
  expect(withoutConfirmation(checks, [1, 2]).map(({ vehicle_id: id, name }) => `${id} ${name}`)).toEqual([
    "0 area",
    "2 battery",
  ]);
});

test("a launch may confirm as many vehicles as planned, and no other number", () => {
  const mission = { planned_vehicles: 2, phase: "preflight" as const, vehicles: [heard(1), heard(2), heard(3)] };
  expect(isProposal(mission, [1, 2])).toBe(true);
  expect(isProposal(mission, [1, 2, 3])).toBe(false);
  expect(isProposal({ ...mission, phase: "connect" }, [1, 2])).toBe(false);
  expect(isProposal({ ...mission, vehicles: [1, 2].map((id) => heard(id, { takes_part: true })) }, [1, 2])).toBe(false);
});

test("checks are rows where they would be cut as columns and vehicles would not", () => {
  const matrix = (vehicles: number, checks: number) => ({
    mission: [],
    names: Array.from({ length: checks }, (_, index) => `check ${index}`),
    rows: Array.from({ length: vehicles }, (_, index) => ({ id: index + 1, checks: [] })),
  });
  expect([1600, 900, 780, 380].map((width_px) => areChecksRows(matrix(8, 25), width_px))).toEqual([
    false,
    true,
    true,
    true,
  ]);
  expect(areChecksRows(matrix(100, 25), 780)).toBe(false);
  expect(areChecksRows(matrix(3, 6), 780)).toBe(false);
});
