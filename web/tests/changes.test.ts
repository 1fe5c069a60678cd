import { expect, test } from "vitest";
import { applyChanges } from "../src/api/changes";
import type { PreflightCheck } from "../src/api/types";
import { mission, vehicle } from "./samples";

const before = mission({ vehicles: [vehicle(1), vehicle(2)] });
const changes = { kind: "changes" as const, seq: 1, mission_age_s: 0, seen: "m-1/0/0", utc_s: 0, preflight: [] };

test("changes only what is named, and keeps the rest as the same objects", () => {
  const after = applyChanges(before, {
    ...changes,
    mission: { elapsed_s: 9 },
    vehicles: [{ vehicle_id: 2, link_age_s: 4.5 }],
  });
  expect(after.elapsed_s).toBe(9);
  expect(after.phase).toBe(before.phase);
  expect(after.vehicles[0]).toBe(before.vehicles[0]);
  expect(after.vehicles[1]).toEqual({ ...before.vehicles[1], link_age_s: 4.5 });
  expect(before.vehicles[1]?.link_age_s).not.toBe(4.5);
});

test("takes in new vehicles in the order of their ids", () => {
  const after = applyChanges(before, { ...changes, mission: {}, vehicles: [{ ...vehicle(3) }, { ...vehicle(0) }] });
  expect(after.vehicles.map((one) => one.vehicle_id)).toEqual([0, 1, 2, 3]);
});

test("without a change of vehicles their list stays the same", () => {
  expect(applyChanges(before, { ...changes, mission: {}, vehicles: [] }).vehicles).toBe(before.vehicles);
});

test("replaces single checks of preflight", () => {
  const check = (name: string, text: string): PreflightCheck => ({
    vehicle_id: 1,
    name,
    status: "pass",
    text,
    remedy: "",
    overridable: false,
    overridden: null,
    blocks: false,
  });
  const known = mission({ preflight: [check("link", "heard"), check("home", "set")] });
  const after = applyChanges(known, { ...changes, mission: {}, vehicles: [], preflight: [check("home", "moved")] });
  expect(after.preflight.map((one) => one.text)).toEqual(["heard", "moved"]);
  expect(after.preflight[0]).toBe(known.preflight[0]);
});
