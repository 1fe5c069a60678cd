import { expect, test } from "vitest";
import { alertText } from "../src/shell/use_alerts";
import { openAlerts, sharedText } from "../src/state/alerts";
import { attentionOf } from "../src/state/attention";
import { areGrounded, isOffered } from "../src/state/commands";
import { sparkPath } from "../src/ui/sparkline";
import { COLUMNS, layoutOf, readSettings } from "../src/views/fly/fleet_settings";
import { countRows, makeRows, orderedIds, steadyOrder } from "../src/views/fly/rows";
import { mission, notice, vehicle } from "./samples";

const GROUNDED = { armed: false, landed: "on_ground", task: "landed" } as const;

test("a vehicle that is well needs nothing, and what is not known is no problem", () => {
  expect(attentionOf(vehicle(1), 0)).toEqual({ level: "good", causes: [] });
  const unknown = vehicle(1, { gps_fix: null, battery_percent: null, packet_loss_percent: null });
  expect(attentionOf(unknown, 0).level).toBe("good");
});

test("what endangers a flight is critical, comes first, and is a warning on the ground", () => {
  const blind = { gps_fix: 1, battery_percent: 20, text: "EKF variance" };
  const flying = attentionOf(vehicle(1, blind), 0);
  expect(flying).toEqual({ level: "critical", causes: ["GPS: no fix", "battery 20\u202f%", "EKF variance"] });
  expect(attentionOf(vehicle(1, { ...blind, ...GROUNDED }), 0).level).toBe("warning");
});

test("without contact only the silence counts: the values are old", () => {
  const silent = vehicle(1, { link_age_s: 7, battery_percent: 3, gps_fix: 0 });
  expect(attentionOf(silent, 0)).toEqual({ level: "critical", causes: ["no contact 7.0\u202fs"] });
  expect(attentionOf(vehicle(1, { link_age_s: 1 }), 6).causes).toEqual(["no contact 7.0\u202fs"]);
  expect(attentionOf(vehicle(1, { link_age_s: null }), 0).causes).toEqual(["no contact yet"]);
  expect(attentionOf(vehicle(1, { link_age_s: null, takes_part: false }), 0).level).toBe("good");
  // Switched off after its flight.
  expect(attentionOf(vehicle(1, { link_age_s: 600, ...GROUNDED }), 0).level).toBe("good");
  expect(attentionOf(vehicle(1, { link_age_s: 600, ...GROUNDED, task: "idle" }), 0).level).toBe("warning");
});

const FLEET = [
  vehicle(1),
  vehicle(2, { battery_percent: 12 }),
  vehicle(3, { link_age_s: 9 }),
  vehicle(4, GROUNDED),
  vehicle(5, { text: "EKF variance" }),
];

test("the worst come first and filters say how many pass", () => {
  const rows = makeRows(FLEET, 0);
  expect(orderedIds(rows, "all", "worst")).toEqual([3, 2, 5, 1, 4]);
  expect(orderedIds(rows, "all", "number")).toEqual([1, 2, 3, 4, 5]);
  expect(orderedIds(rows, "attention", "worst")).toEqual([3, 2, 5]);
  expect(orderedIds(rows, "airborne", "number")).toEqual([1, 2, 3, 5]);
  expect(orderedIds(rows, "battery", "worst")).toEqual([2]);
  expect(countRows(rows)).toEqual({ all: 5, attention: 3, airborne: 4, battery: 1 });
});

test("a mission that is not heard leaves the order and the filters as they were", () => {
  const rows = makeRows(FLEET, 60);
  expect(rows[0]?.attention.level).toBe("critical");
  expect(orderedIds(rows, "all", "worst")).toEqual([3, 2, 5, 1, 4]);
  expect(orderedIds(rows, "attention", "worst")).toEqual([3, 2, 5]);
});

test("what is about to be pressed stays where it is; who is new comes last", () => {
  expect(steadyOrder([3, 1, 2], [2, 1, 3, 9])).toEqual([3, 1, 2, 9]);
  expect(steadyOrder([3, 1, 2], [2, 3])).toEqual([3, 2]);
});

test("settings of the fleet survive what this page does not know", () => {
  expect(readSettings(null)).toEqual({ layout: null, order: "worst", columns: COLUMNS });
  expect(readSettings("{")).toEqual(readSettings(null));
  expect(readSettings("[]")).toEqual(readSettings(null));
  expect(readSettings('{"layout":"tiles","order":"x","columns":["link","smell","task"]}')).toEqual({
    layout: "tiles",
    order: "worst",
    columns: ["task", "link"],
  });
  expect(layoutOf(readSettings(null), 20, 1280)).toBe("table");
  expect(layoutOf(readSettings(null), 21, 1280)).toBe("tiles");
  expect(layoutOf(readSettings(null), 3, 390)).toBe("tiles");
  expect(layoutOf(readSettings('{"layout":"table"}'), 3, 390)).toBe("table");
  expect(layoutOf(readSettings('{"layout":"table"}'), 100, 1280)).toBe("table");
});

test("one cause is one alert, with the range of its numbers", () => {
  expect(sharedText("battery at 24 %", "battery at 24 %")).toBe("battery at 24 %");
  expect(sharedText("battery at 24 %", "battery at 21 %")).toBe("battery at 21–24 %");
  expect(sharedText("battery at 21–24 %", "battery at 9.5 %")).toBe("battery at 9.5–24 %");
  const notices = [
    notice(1, "battery at 24 %", { vehicle_id: 7 }),
    notice(2, "battery at 22 %", { vehicle_id: 8 }),
    notice(3, "battery at 20 %", { vehicle_id: 7 }),
    notice(4, "no GPS fix", { vehicle_id: 7 }),
  ];
  const [fix, battery, ...others] = openAlerts(notices, []);
  expect(others).toEqual([]);
  expect(fix && alertText(fix)).toBe("Vehicle 7: no GPS fix");
  expect(battery && alertText(battery)).toBe("2 vehicles (7–8): battery at 20–24 %");
  // To acknowledge it is to acknowledge every text of it.
  expect(battery?.ids).toEqual([1, 2, 3]);
  expect(
    openAlerts(
      notices,
      [1, 2, 3].map((notice_id) => ({ notice_id, operator: "", utc_s: 0 })),
    ),
  ).toHaveLength(1);
});

test("vehicles that have landed are offered what makes sense, and always a hold", () => {
  const flown = mission({ vehicles: FLEET });
  const [landed, both] = [new Set([4]), new Set([1, 4])];
  expect(isOffered("return", flown, landed)).toBe(false);
  expect(isOffered("land", flown, landed)).toBe(false);
  expect(isOffered("hold", flown, landed)).toBe(true);
  expect(isOffered("return", flown, both)).toBe(true);
  expect(isOffered("return", flown, new Set())).toBe(true);
  expect(areGrounded(flown, landed)).toBe(true);
  expect(areGrounded(mission({ vehicles: [vehicle(1, { armed: null, landed: "on_ground" })] }), new Set([1]))).toBe(
    false,
  );
});

test("curves begin anew after a gap, always end with the latest value, and noise stays small", () => {
  expect(sparkPath([null, null], 10)).toBe("");
  expect(sparkPath([0, 10, null, 0, 10], 1)).toBe("M0.0 28.0L25.0 2.0M75.0 28.0L100.0 2.0");
  expect(sparkPath([50, 51], 10)).toBe("M0.0 16.3L100.0 13.7");
  const long = sparkPath(
    Array.from({ length: 900 }, (_, index) => index),
    1,
  );
  expect(long.split(/[ML]/).length - 1).toBeLessThanOrEqual(120);
  expect(long.endsWith(" 2.0")).toBe(true);
});
