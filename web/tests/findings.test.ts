import { expect, test } from "vitest";
import { likelihood } from "../src/format";
import { alertedFinding, undecidedAlerted } from "../src/state/findings";
import { notations } from "../src/views/decide/findings";
import { ellipseText, evidenceText, listed, reported, sightingsText, statusText } from "../src/views/decide/findings";
import { findingsLayer } from "../src/views/decide/findings_layer";
import { drawn, scene } from "./fake_map";
import { finding, mission } from "./samples";

const FINDINGS = [
  finding(1, { status: "confirmed" }),
  finding(2, { seen_at_s: 10 }),
  finding(3, { status: "rejected" }),
  finding(4, { seen_at_s: 50 }),
];
const ids = (findings: readonly { finding_id: number }[]): number[] => findings.map(({ finding_id }) => finding_id);

test("what waits for a decision comes first, the latest seen before the others", () => {
  expect(ids(listed(FINDINGS, "all"))).toEqual([4, 2, 1, 3]);
  expect(ids(listed(FINDINGS, "open"))).toEqual([4, 2]);
  expect(ids(listed(FINDINGS, "rejected"))).toEqual([3]);
});

test("the report begins with what is confirmed", () => {
  expect(ids(reported(FINDINGS))).toEqual([1, 4, 2, 3]);
});

test("findings of a survey come by their significance, possible persons first", () => {
  const findings = [
    finding(1, { kind: "anomaly", significance: 6, seen_at_s: 90 }),
    finding(2, { kind: "warm_object", significance: 30, seen_at_s: 80 }),
    finding(3, { kind: "anomaly", significance: 9, seen_at_s: 10 }),
    finding(4, { kind: "undecided", track_id: null, seen_at_s: 5 }),
    finding(5, { kind: "anomaly", significance: 50, status: "rejected" }),
  ];
  expect(ids(listed(findings, "all"))).toEqual([4, 3, 1, 2, 5]);
  expect(ids(reported(findings))).toEqual([4, 3, 1, 2, 5]);
});

test("a finding of a survey is told by frames, and by its significance where no probability is known", () => {
  const found = finding(1, { kind: "anomaly", significance: 8.96, person_confidence: null, sightings: 12 });
  expect(sightingsText(found)).toBe("12 frames");
  expect(evidenceText(found)).toBe("Significance: 9.0");
  expect(evidenceText({ ...found, person_confidence: 0.8 })).toBe("Person probability: 80\u202f%");
  expect(evidenceText(finding(1, { person_confidence: null }))).toBe("Person probability: no data");
});

test("a finding that is an earlier one points to it, and counts no more", () => {
  const all = [finding(1), finding(2, { merged_into: 1, status: "confirmed" })];
  expect(ids(listed(all, "all"))).toEqual([1, 2]);
  expect(ids(listed(all, "open"))).toEqual([1]);
  expect(ids(listed(all, "confirmed"))).toEqual([]);
  expect(ids(reported(all))).toEqual([1]);
  expect(all.map(statusText)).toEqual(["? undecided", "Same as finding 1"]);
  const layer = findingsLayer(
    () => null,
    () => undefined,
  );
  const features = drawn(layer, scene({ mission: mission({ findings: all }) }));
  expect(features.map((feature) => feature.properties?.["name"])).toEqual(["Finding 1 ?"]);
});

test("what is not known is told as such, never as a zero", () => {
  expect(likelihood(null)).toBe("no data");
  expect(likelihood(0)).toBe("0\u202f%");
  expect(likelihood(0.724)).toBe("72\u202f%");
  expect(sightingsText(finding(1, { track_id: null, sightings: 0 }))).toBe("no data");
  expect(sightingsText(finding(1, { track_id: 3, sightings: 12 }))).toBe("12 sightings");
  expect(ellipseText(finding(1, { sigma_m: null }))).toBe("–");
  const ellipse = { semi_major_m: 2, semi_minor_m: 1, heading_deg: 30 };
  expect(ellipseText(finding(1, { ellipse }))).toBe("2.0 × 1.0\u202fm, 30\u202f°");
});

test("the chosen notation comes first, and none without an origin on the globe", () => {
  expect(notations(finding(1), "utm")).toEqual([]);
  const { position } = finding(1);
  const at = (latitude_deg: number) =>
    notations(finding(1, { position: { ...position, latitude_deg, longitude_deg: 14.3 } }), "utm");
  expect(at(48.3).map(([name]) => name)).toEqual(["utm", "decimal", "dms", "mgrs"]);
  expect(at(48.3)[0]).toEqual(["utm", "33U 448087 5349882"]);
  expect(at(86).map(([name]) => name)).toEqual(["utm", "dms"]);
});

test("findings have their numbers and signs on the map, the chosen one stands out", () => {
  const layer = findingsLayer(
    () => 3,
    () => undefined,
  );
  const features = drawn(layer, scene({ mission: mission({ findings: FINDINGS }) }));
  expect(features.map((feature) => feature.properties?.["name"])).toEqual([
    "Finding 1 ✓",
    "Finding 2 ?",
    "Finding 3 ✗",
    "Finding 4 ?",
  ]);
  expect(features.filter((feature) => feature.properties?.["isChosen"])).toHaveLength(1);
});

test("the first alert that is about a finding leads to it", () => {
  const findings = [
    finding(1, { track_id: 7 }),
    finding(2, { track_id: 8 }),
    finding(3, { track_id: 9, merged_into: 1 }),
  ];
  const found = (...tracks: (number | null)[]) =>
    alertedFinding(
      tracks.map((trackId) => ({ trackId })),
      findings,
    )?.finding_id;
  expect(found(null, 8, 7)).toBe(2);
  expect(found(9)).toBe(1);
  expect(found(null, 4)).toBeUndefined();
});

test("the map shows the first alerted finding that is neither decided nor closed", () => {
  const findings = [
    finding(1, { track_id: 7, status: "confirmed" }),
    finding(2, { track_id: 8 }),
    finding(3, { track_id: 9 }),
  ];
  const alerts = [null, 7, 8, 9].map((trackId) => ({ trackId }));
  expect(undecidedAlerted(alerts, findings, new Set())?.finding_id).toBe(2);
  expect(undecidedAlerted(alerts, findings, new Set([2]))?.finding_id).toBe(3);
  expect(undecidedAlerted(alerts, findings, new Set([2, 3]))).toBeNull();
});
