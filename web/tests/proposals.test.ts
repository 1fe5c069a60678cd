import { describe, expect, it } from "vitest";
import type { Place, Plan, Proposal } from "../src/api/types";
import { featureOf } from "../src/map/layers/proposals";
import { bySender, waiting } from "../src/state/proposals";
import { describe as described } from "../src/views/plan/proposals";
import { withProposal } from "../src/views/plan/shapes";

const PLACES: Place[] = [
  { latitude_deg: 48, longitude_deg: 15 },
  { latitude_deg: 48, longitude_deg: 15.01 },
  { latitude_deg: 48.01, longitude_deg: 15.01 },
];
const PROPOSAL: Proposal = {
  proposal_id: 3,
  source: "TAK",
  name: "Ravine",
  sender: "EAGLE 1",
  kind: "u-d-f",
  shape: "area",
  places: PLACES,
  altitude_amsl_m: null,
  remarks: "",
  uses: ["area", "no_go", "fence", "dismissed"],
  sent_utc_s: 1_795_000_000,
  stale_utc_s: 1_795_000_300,
  received_utc_s: 1_795_000_005,
  use: null,
  operator: "",
};
const PLAN = { area: [], no_go: [[]], launch: null } as unknown as Plan;

describe("proposals of others", () => {
  it("wait until somebody has decided", () => {
    expect(waiting([PROPOSAL, { ...PROPOSAL, use: "dismissed" }])).toEqual([PROPOSAL]);
  });

  it("are dismissed together where one sender has sent many", () => {
    const flood = [1, 2, 3, 4].map((proposal_id) => ({ ...PROPOSAL, proposal_id, sender: "LOUD" }));
    expect(bySender([PROPOSAL, ...flood])).toEqual([["LOUD", flood]]);
    expect(bySender([PROPOSAL, ...flood.slice(1)])).toEqual([]);
  });

  it("change the plan as they were taken over, and not otherwise", () => {
    expect(withProposal(PLAN, { ...PROPOSAL, use: "no_go" }).no_go).toEqual([[], PLACES]);
    expect(withProposal(PLAN, { ...PROPOSAL, use: "area" }).area).toEqual(PLACES);
    const point = { ...PROPOSAL, places: PLACES.slice(0, 1) };
    expect(withProposal(PLAN, { ...point, use: "launch" }).launch).toEqual(PLACES[0]);
    for (const use of [null, "finding", "dismissed"] as const) {
      expect(withProposal(PLAN, { ...point, use })).toBe(PLAN);
    }
  });

  it("tell their sender, time, form and age", () => {
    expect(described(PROPOSAL, 1_795_000_100)).toMatch(/^EAGLE 1 via TAK, \d\d:\d\d:\d\d .+; area, 3 corners$/);
    const point: Proposal = { ...PROPOSAL, sender: "", shape: "point", altitude_amsl_m: 300.4 };
    expect(described(point, 1_795_000_400)).toMatch(
      /^Unnamed sender via TAK, .+; point; 300 m above sea level; out of date since \d\d:\d\d:\d\d/,
    );
  });

  it("are drawn closed where they are areas", () => {
    const corners = PLACES.map(({ longitude_deg, latitude_deg }) => [longitude_deg, latitude_deg]);
    expect(featureOf(PROPOSAL).geometry).toEqual({ type: "Polygon", coordinates: [[...corners, corners[0]]] });
    expect(featureOf({ ...PROPOSAL, shape: "line" }).geometry).toEqual({ type: "LineString", coordinates: corners });
    expect(featureOf({ ...PROPOSAL, shape: "point" }).geometry).toEqual({ type: "Point", coordinates: corners[0] });
  });
});
