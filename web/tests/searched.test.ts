import { describe, expect, test } from "vitest";
import type { Picture } from "../src/api/types";
import { searchedLayer } from "../src/map/layers/picture";
import { searchedFacts, segmentRows } from "../src/panels/searched";
import { INITIAL_STATE } from "../src/state/state";
import { searchedKind } from "../src/state/searched";
import { texts } from "../src/texts";
import { FakeMap, scene } from "./fake_map";
import { mission } from "./samples";

const corner = (longitude_deg: number, latitude_deg: number) => ({
  east_m: 0,
  north_m: 0,
  longitude_deg,
  latitude_deg,
});
const CORNERS = [corner(14, 49), corner(15, 49), corner(15, 48), corner(14, 48)];
const picture = (kind: "views" | "detection", url: string): Picture => ({ kind, step: 3, url, corners: CORNERS });
const GROUND = {
  frames: 30,
  left_out: 0,
  seen_percent: 62.6,
  mean_views: 4.26,
  detection_percent: { standing: 51.2, sitting: 70, lying: 88.4 },
  soon_percent: 71.3,
  success_percent: 38.4,
  segments: [],
};

describe("the layer of what has been searched", () => {
  test("shows the views until the probability of detection is known", () => {
    const views = picture("views", "v.png");
    expect(searchedKind({})).toBeNull();
    expect(searchedKind({ views })).toBe("views");
    expect(searchedKind({ views, detection: picture("detection", "d.png") })).toBe("detection");
  });

  test("follows new pictures, and is empty in a mission that has none", () => {
    const map = new FakeMap();
    const layer = map.attach(searchedLayer);
    const shown = (pictures: typeof INITIAL_STATE.pictures) =>
      layer.update({ ...scene(), state: { ...INITIAL_STATE, pictures } });
    shown({ views: picture("views", "a.png") });
    shown({ views: picture("views", "b.png") });
    shown({});
    expect(map.images).toEqual(["a.png", "b.png"]);
    expect(map.properties.at(-1)).toContain("visibility");
  });
});

describe("the facts about a search", () => {
  const shown = (changes: Parameters<typeof mission>[0]) =>
    Object.fromEntries(searchedFacts(mission(changes)).filter(([, value]) => value !== ""));

  test("name what is known", () => {
    const leg = { start: corner(14, 48), end: corner(15, 48) };
    expect(shown({ ground: GROUND, legs: [leg, leg], leg: 1, scan_left_s: 252 })).toEqual({
      "Area seen": "63\u202f%",
      Leg: "2 of 2",
      "Time left on the legs": "04:12",
      "Detection, standing": "51\u202f%",
      "Detection, sitting": "70\u202f%",
      "Detection, lying": "88\u202f%",
      "Success, by the prior": "38\u202f%",
      "Detection, standing, with 10 more minutes": "71\u202f%",
      "Independent views": "4.3",
    });
  });

  test("leave out what is not known, and count no leg beyond the last one", () => {
    const leg = { start: corner(14, 48), end: corner(15, 48) };
    const facts = shown({
      ground: { ...GROUND, detection_percent: null, success_percent: null, left_out: 4 },
      legs: [leg],
      leg: 1,
    });
    expect(facts).toEqual({
      "Area seen": "63\u202f%",
      Leg: "1 of 1",
      "Independent views": "4.3",
      "Frames not mapped": "4",
    });
    expect(shown({ covered_percent: 12 })).toEqual({ "Area seen": "12\u202f%" });
  });
});

describe("the table of segments", () => {
  test("has a row for each, and says what is not known", () => {
    const segment = { name: "A 1", hectares: 1.2, seen_percent: 80.4, probability_percent: 30 };
    expect(
      segmentRows([
        { ...segment, detection_percent: 61.6, success_percent: 18.9 },
        { ...segment, name: "B", detection_percent: null, success_percent: null },
      ]),
    ).toEqual([
      ["A 1", "80\u202f%", "62\u202f%", "19\u202f%"],
      ["B", "80\u202f%", texts.noData, texts.noData],
    ]);
  });
});
