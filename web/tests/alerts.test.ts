import { expect, test } from "vitest";
import type { Notice } from "../src/api/types";
import { acknowledge, openAlerts } from "../src/state/alerts";

const notice = (severity: Notice["severity"], text: string, elapsed_s: number, vehicle_id: number | null = null) => ({
  severity,
  text,
  elapsed_s,
  vehicle_id,
});

test("critical alerts come first, then newer ones; info is no alert", () => {
  const notices = [
    notice("critical", "link lost", 1, 3),
    notice("warning", "battery", 2),
    notice("info", "step 4", 3),
    notice("warning", "wind", 4),
  ];
  expect(openAlerts(notices, new Map()).map((alert) => alert.text)).toEqual(["link lost", "wind", "battery"]);
});

test("repetitions are one alert with a count, of each vehicle its own", () => {
  const notices = [1, 2, 5]
    .map((time) => notice("warning", "battery", time, 1))
    .concat(notice("warning", "battery", 3, 2));
  const alerts = openAlerts(notices, new Map());
  expect(alerts.map(({ vehicleId, count, elapsed_s }) => [vehicleId, count, elapsed_s])).toEqual([
    [1, 3, 5],
    [2, 1, 3],
  ]);
});

test("what was acknowledged opens again when it comes again", () => {
  const first = [notice("warning", "battery", 1)];
  const acknowledged = acknowledge(new Map(), openAlerts(first, new Map()));
  expect(openAlerts(first, acknowledged)).toEqual([]);
  const again = openAlerts([...first, notice("warning", "battery", 9)], acknowledged);
  expect(again.map(({ elapsed_s, count }) => [elapsed_s, count])).toEqual([[9, 1]]);
});
