import { expect, test } from "vitest";
import type { PreflightCheck } from "../src/api/types";
import { matrixOf, verdictOf } from "../src/views/prepare/checks";

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
  expect(verdictOf(check(1, "link", { status: "fail", overridden }))).toBe("overridden");
  expect(verdictOf(check(1, "link", { status: "warn" }))).toBe("warn");
});
