import { expect, test } from "vitest";
import type { NumberedNotice } from "../src/state/state";
import { acknowledge, openAlerts } from "../src/state/alerts";

const notice = (
  severity: NumberedNotice["severity"],
  text: string,
  id: number,
  vehicle_id: number | null = null,
): NumberedNotice => ({ severity, text, id, vehicle_id, elapsed_s: 0 });

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
  expect(alerts.map(({ vehicleId, count, id }) => [vehicleId, count, id])).toEqual([
    [1, 3, 5],
    [2, 1, 3],
  ]);
});

test("what was acknowledged opens again when it comes again", () => {
  const first = [notice("warning", "battery", 1)];
  const acknowledged = acknowledge(new Map(), openAlerts(first, new Map()));
  expect(openAlerts(first, acknowledged)).toEqual([]);
  const again = openAlerts([...first, notice("warning", "battery", 9)], acknowledged);
  expect(again.map(({ id, count }) => [id, count])).toEqual([[9, 1]]);
});
