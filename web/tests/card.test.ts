import { expect, test } from "vitest";
import { thumbnailUrl } from "../src/api/findings";
import { bearing, distance } from "../src/format";
import { bearingAndDistance } from "../src/geometry";
import { findingText } from "../src/shell/finding_text";
import { openAlerts } from "../src/state/alerts";
import { findingOfTrack } from "../src/state/findings";
import { messageAbout } from "../src/views/decide/message";
import { launchSite, wayTo } from "../src/views/decide/way";
import { finding, mission, notice, vehicle } from "./samples";

const AT = { east_m: 30, north_m: 40, up_m: 0, latitude_deg: 48.00036, longitude_deg: 14.0004 };

test("bearing and distance are those of the globe, over its seams too", () => {
  const from = { latitude_deg: 48, longitude_deg: 14 };
  const to = (latitude_deg: number, longitude_deg: number) => bearingAndDistance(from, { latitude_deg, longitude_deg });
  expect(to(48.01, 14).bearing_deg).toBe(0);
  expect(to(48.01, 14).distance_m).toBeCloseTo(1112, 0); // a hundredth of a degree of the meridian there
  expect(to(47.99, 14).bearing_deg).toBe(180);
  expect(to(48, 13.99).bearing_deg).toBeCloseTo(270, 6);
  expect(to(48, 13.99).distance_m).toBeCloseTo(746, 0);
  const across = bearingAndDistance(
    { latitude_deg: 0, longitude_deg: 179.99 },
    { latitude_deg: 0, longitude_deg: -179.99 },
  );
  expect(across.bearing_deg).toBeCloseTo(90, 6);
  expect(across.distance_m).toBeCloseTo(2226, 0);
});

test("bearings have three digits and distances the unit that reads best", () => {
  expect([0, 7.4, 359.7].map(bearing)).toEqual(["000°", "007°", "000°"]);
  expect([8.25, 41.3, 1234, 23456].map(distance)).toEqual(["8.3\u202fm", "41\u202fm", "1.23\u202fkm", "23.5\u202fkm"]);
});

test("the way begins at the middle of the launch points, or where the searchers have set it", () => {
  const home = (east_m: number) => ({ east_m, north_m: 0, up_m: 0, latitude_deg: 48, longitude_deg: 14 });
  const launched = mission({ vehicles: [vehicle(1, { home: home(-20) }), vehicle(2, { home: home(20) })] });
  expect(launchSite(launched)?.longitude_deg).toBeCloseTo(14, 9);
  expect(launchSite(mission({ origin: null }))).toBeNull();
  const found = finding(1, { position: AT });
  expect(wayTo(found, launched, null)).toBe("037° true, 50\u202fm from the launch site");
  const north = { latitude_deg: 48.00126, longitude_deg: 14.0004 };
  expect(wayTo(found, launched, north)).toBe("180° true, 100\u202fm from the reference place");
  expect(wayTo(finding(1), launched, null)).toBeNull();
});

test("the message names what, where, when, why and whose it is, and leaves out what is not known", () => {
  const found = finding(3, {
    position: AT,
    kind: "person",
    person_confidence: 0.93,
    reasons: ["12 K warmer", "seen by 5"],
    assignee: "team 2",
    sigma_m: 0.4,
    found_at_s: 65,
  });
  const lines = messageAbout(found, mission({ started_utc_s: 0 }), "mgrs", null).split("\n");
  expect(lines[0]).toBe("Possible person (93\u202f%), finding 3, undecided");
  expect(lines[1]).toBe("33U VP 25435 16823 (MGRS, WGS 84)");
  expect(lines[2]).toBe("48.000360° N, 14.000400° E (Decimal, WGS 84)");
  expect(lines.find((line) => line.startsWith("First seen"))).toMatch(/:01:05 .*\(01:05\)$/);
  expect(lines).toContain("Reasons: 12 K warmer; seen by 5");
  expect(lines).toContain("Assigned to: team 2");
  expect(messageAbout(finding(1), mission(), "mgrs", null)).not.toMatch(/Reasons|Assigned|WGS 84|null/);
});

test("alerts about a target lead to its finding, and to the one that it turned out to be", () => {
  const findings = [finding(1, { track_id: 4 }), finding(2, { track_id: 7, merged_into: 1 })];
  expect(findingOfTrack(findings, 4)?.finding_id).toBe(1);
  expect(findingOfTrack(findings, 7)?.finding_id).toBe(1);
  expect(findingOfTrack(findings, 9)).toBeNull();
  expect(findingOfTrack([finding(1, { track_id: null })], null)).toBeNull();
  const [alert] = openAlerts([notice(1, "Possible person", { severity: "news", track_id: 7 })], []);
  expect(alert?.trackId).toBe(7);
});

test("a finding is told with its place in the notation of the screen", () => {
  const found = finding(2, { position: AT, kind: "person", person_confidence: 0.5, sigma_m: 0.42 });
  expect(findingText(found, "utm")).toBe("Possible person (50\u202f%), 33U 425435 5316824, ± 0.4\u202fm · Finding 2");
  expect(findingText(finding(2), "utm")).toContain("E 20.0\u202fm, N 5.0\u202fm");
});

test("images are those of the step that showed it, on the plane and of the cameras that are wanted", () => {
  const found = finding(5, { step: 17 });
  expect(thumbnailUrl(found, { kind: "thermal" })).toBe("/api/findings/5/thermal.png?step=17");
  expect(thumbnailUrl(found, { kind: "integral", above_m: 2, isNearest: true })).toBe(
    "/api/findings/5/integral.png?step=17&above_m=2&nearest=true",
  );
});
