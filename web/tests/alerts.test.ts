import { expect, test } from "vitest";
import { acknowledgementByNotice, noticesToKeep, openAlerts } from "../src/state/alerts";
import { alertText } from "../src/shell/use_alerts";
import { notice } from "./samples";

const by = (operator: string, notice_id: number) => ({ notice_id, operator, utc_s: 100 + notice_id });

test("critical alerts come first, then news, then newer warnings; info is no alert", () => {
  const notices = [
    notice(1, "link lost", { severity: "critical", vehicle_id: 3 }),
    notice(2, "battery"),
    notice(3, "step 4", { severity: "info" }),
    notice(4, "target found", { severity: "news" }),
    notice(5, "wind"),
  ];
  expect(openAlerts(notices, []).map((alert) => alert.text)).toEqual(["link lost", "target found", "wind", "battery"]);
});

test("repetitions are one alert with a count", () => {
  const notices = [1, 2, 5].map((id) => notice(id, "battery", { vehicle_id: 1 }));
  expect(openAlerts(notices, []).map(({ vehicleIds, count, id }) => [vehicleIds, count, id])).toEqual([[[1], 3, 5]]);
});

test("what several vehicles report in the same words is one alert, until each has been acknowledged", () => {
  const notices = [
    ...[1, 2, 5].map((id) => notice(id, "no fix", { vehicle_id: 4 })),
    notice(6, "no fix", { vehicle_id: 2 }),
    notice(7, "no fix", { vehicle_id: 3 }),
    notice(8, "no fix", { vehicle_id: 9, severity: "critical" }),
    notice(9, "no fix"),
  ];
  const [critical, ofMission, ofVehicles, ...others] = openAlerts(notices, []);
  expect(others).toEqual([]);
  expect([critical, ofMission, ofVehicles].map((alert) => alert && alertText(alert))).toEqual([
    "Vehicle 9: no fix",
    "no fix",
    "3 vehicles (2–4): no fix",
  ]);
  expect([ofVehicles?.ids, ofVehicles?.id, ofVehicles?.count]).toEqual([[5, 6, 7], 7, 3]);
  expect(openAlerts(notices, [by("Ada", 5), by("Ada", 7)]).at(-1)?.vehicleIds).toEqual([2]);
  expect(
    openAlerts(
      notices,
      [5, 6, 7, 8, 9].map((id) => by("Ada", id)),
    ),
  ).toEqual([]);
});

test("what an operator has acknowledged is open on no screen, until it comes again", () => {
  const first = [notice(1, "battery"), notice(2, "battery")];
  expect(openAlerts(first, [by("Ada", 2)])).toEqual([]);
  expect(openAlerts(first, [by("Ada", 1)]).map(({ id, count }) => [id, count])).toEqual([[2, 1]]);
  const again = openAlerts([...first, notice(9, "battery")], [by("Ada", 2)]);
  expect(again.map(({ id, count }) => [id, count])).toEqual([[9, 1]]);
});

test("an acknowledgement covers earlier repetitions, each by the first that came after it", () => {
  const notices = [notice(1, "wind"), notice(2, "battery"), notice(3, "wind"), notice(4, "wind"), notice(5, "wind")];
  const who = acknowledgementByNotice(notices, [by("Ada", 3), by("Bob", 4), by("Eve", 99)]);
  expect([...who].map(([id, { operator }]) => [id, operator]).sort()).toEqual([
    [1, "Ada"],
    [3, "Ada"],
    [4, "Bob"],
  ]);
});

test("no flood of information drops an alert that is open", () => {
  const flood = Array.from({ length: 250 }, (_, index) => notice(10 + index, `text ${index}`, { severity: "info" }));
  const alerts = [
    notice(1, "battery"),
    notice(2, "link lost", { severity: "critical" }),
    notice(3, "motors stopped", { severity: "critical" }),
  ];
  const kept = noticesToKeep([...alerts, ...flood], [by("Ada", 3)], 200);
  expect(kept).toHaveLength(200);
  expect(kept.slice(0, 4).map(({ notice_id }) => notice_id)).toEqual([1, 2, 3, 63]);
  expect(noticesToKeep(alerts, [by("Ada", 3)], 2).map(({ notice_id }) => notice_id)).toEqual([1, 2]);
  expect(noticesToKeep(alerts, [by("Ada", 3)], 1).map(({ notice_id }) => notice_id)).toEqual([2]);
});
