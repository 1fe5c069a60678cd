import type { LineString } from "geojson";
import { afterEach, expect, test, vi } from "vitest";
import { overlayOf } from "../src/map/layer_switch";
import { areaLayer } from "../src/map/layers/area";
import { gridLayer } from "../src/map/layers/grid";
import { homesLayer } from "../src/map/layers/homes";
import { heightsLayer } from "../src/map/layers/heights";
import { pictureLayer } from "../src/map/layers/picture";
import { contoursLayer, shadingLayer } from "../src/map/layers/relief";
import { targetsLayer } from "../src/map/layers/targets";
import { trailsLayer } from "../src/map/layers/trails";
import { vehiclesLayer } from "../src/map/layers/vehicles";
import { waypointsLayer } from "../src/map/layers/waypoints";
import { INITIAL_STATE } from "../src/state/state";
import { texts } from "../src/texts";
import { drawn, FakeMap, ORIGIN, scene } from "./fake_map";
import { mission, position, step, target, vehicle } from "./samples";

const square = (half_m: number) =>
  [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ].map(([e = 0, n = 0]) => ({ east_m: e * half_m, north_m: n * half_m, latitude_deg: null, longitude_deg: null }));

// Without a browser there is no canvas to draw them on.
vi.mock("../src/map/arrows", () => ({ addArrows: () => undefined, arrowName: () => "arrow" }));
afterEach(() => vi.useRealTimers());

test("data goes to the map only when its own part of the scene has changed, and not too often", () => {
  vi.useFakeTimers({ toFake: ["performance"] });
  const map = new FakeMap();
  const layer = map.attach(trailsLayer);
  const changes = (): number | undefined => map.sources.get("trails")?.changes;
  const flown = { ...INITIAL_STATE, trails: new Map([[1, [[0, 0] as const, [5, 0] as const]]]) };
  const flownOn = { ...flown, trails: new Map([[1, [[0, 0] as const, [5, 0] as const, [6, 0] as const]]]) };
  layer.update(scene({ state: flown }));
  vi.advanceTimersByTime(5000);
  layer.update(scene({ state: { ...flown, latestStep: step(1) }, snapshotAge_s: 3 }));
  expect(changes()).toBe(1);
  layer.update(scene({ state: flownOn }));
  layer.update(scene({ state: flown }));
  expect(changes()).toBe(2);
  vi.advanceTimersByTime(5000);
  layer.update(scene({ state: flown }));
  expect(changes()).toBe(3);
});

test("the map is not drawn again for vehicles that are where they were", () => {
  const map = new FakeMap();
  const layer = map.attach(vehiclesLayer(() => undefined));
  const changes = (): number | undefined => map.sources.get("vehicles")?.changes;
  const at = (east_m: number, snapshotAge_s: number) =>
    scene({ mission: mission({ vehicles: [vehicle(1, { position: position(east_m, 0) })] }), snapshotAge_s });
  layer.update(at(3, 0));
  layer.update(at(3, 0.1));
  layer.update(at(3, 1.1));
  expect(changes()).toBe(1);
  layer.update(at(4, 0));
  expect(changes()).toBe(2);
  layer.update(at(4, 60)); // paler, because it is outdated
  expect(changes()).toBe(3);
});

const CORNERS = square(9).map((corner) => ({ ...corner, latitude_deg: 48, longitude_deg: 14 }));
const withPicture = (url: string) => ({
  ...INITIAL_STATE,
  pictures: { thermal: { kind: "thermal" as const, step: 1, url, corners: CORNERS } },
});
const shownWith = (opacity: number, url = "a.png") =>
  scene({ state: withPicture(url), overlay: { kind: "thermal", opacity } });

test("the map is not drawn again for a picture that stays", () => {
  const map = new FakeMap();
  const layer = map.attach(pictureLayer);
  const hidden = scene({ state: withPicture("a.png") });
  layer.update(hidden);
  expect(map.properties).toEqual([]);
  layer.update(shownWith(0.5));
  layer.update(shownWith(0.5));
  expect(map.properties).toEqual(["visibility: visible", "raster-opacity: 0.5"]);
  layer.update(shownWith(0.7));
  layer.update(hidden);
  layer.update(hidden);
  expect(map.properties.slice(2)).toEqual(["raster-opacity: 0.7", "visibility: none"]);
  expect(map.images).toEqual(["a.png"]);
});

test("a picture that was replaced while it was hidden is the new one when it is shown again", () => {
  const map = new FakeMap();
  const layer = map.attach(pictureLayer);
  layer.update(shownWith(0.5));
  layer.update(scene({ state: withPicture("b.png") }));
  layer.update(shownWith(0.5, "b.png"));
  expect(map.images).toEqual(["a.png", "b.png"]);
  expect(map.properties.slice(2)).toEqual(["visibility: none", "visibility: visible"]);
  layer.remove();
  expect([...map.layers, ...map.sources.keys()]).toEqual([]);
  map.attach(pictureLayer).update(shownWith(0.5, "b.png"));
  expect(map.images.at(-1)).toBe("b.png");
  expect(map.properties.slice(4)).toEqual(["visibility: visible", "raster-opacity: 0.5"]);
});

test("the forest floor can be chosen as the image on the ground", () => {
  const map = new FakeMap();
  const layer = map.attach(pictureLayer);
  const pictures = { floor: { kind: "floor" as const, step: 1, url: "floor.png", corners: CORNERS } };
  const choice = { hidden: new Set<string>(), kind: "floor" as const, opacity: 0.5 };
  layer.update(scene({ state: { ...INITIAL_STATE, pictures }, overlay: overlayOf(choice) }));
  expect(map.images).toEqual(["floor.png"]);
  expect(map.properties).toEqual(["visibility: visible", "raster-opacity: 0.5"]);
  expect(texts.names.picture.floor).toBe("Forest floor");
});

test("a picture on its way is not given up for the next one before 20 s", () => {
  vi.useFakeTimers();
  const map = new FakeMap();
  const layer = map.attach(pictureLayer);
  layer.update(shownWith(0.5, "a.png"));
  map.areImagesLoaded = false;
  layer.update(shownWith(0.5, "b.png"));
  expect(map.images).toEqual(["a.png"]);
  map.areImagesLoaded = true;
  layer.update(shownWith(0.5, "c.png"));
  expect(map.images).toEqual(["a.png", "c.png"]);
  map.areImagesLoaded = false;
  vi.advanceTimersByTime(20_000);
  layer.update(shownWith(0.5, "d.png"));
  expect(map.images).toEqual(["a.png", "c.png", "d.png"]);
});

test("a layer that is removed leaves nothing behind", () => {
  const map = new FakeMap();
  map.attach(areaLayer).remove();
  expect(map.layers).toEqual([]);
  expect(map.sources.size).toBe(0);
});

test("layers that share a source draw their own features of it, and leave the others theirs", () => {
  const map = new FakeMap();
  const shown = scene({ mission: mission({ area: square(9), vehicles: [vehicle(1, { home: position(0, 0) })] }) });
  const [area, homes] = [map.attach(areaLayer), map.attach(homesLayer)];
  const layersOf = (): unknown[] =>
    [...map.sources.values()].flatMap(({ data }) => data.features.map(({ properties }) => properties?.["layer"]));
  area.update(shown);
  homes.update(shown);
  expect(map.sources.size).toBe(1);
  expect(layersOf()).toEqual(["area", "homes"]);
  expect(map.layers.filter((id) => id.startsWith("homes")).map((id) => map.filters.get(id))).toEqual([
    ["==", ["get", "layer"], "homes"],
  ]);
  area.remove();
  homes.update(scene({ mission: mission({ vehicles: [] }) }));
  expect(map.sources.size).toBe(1);
  expect(layersOf()).toEqual([]);
  homes.remove();
  expect(map.sources.size).toBe(0);
  expect(map.layers).toEqual([]);
});

test("area and fence are closed rings; incomplete ones are not drawn", () => {
  const features = drawn(areaLayer, scene({ mission: mission({ area: square(9), fence: square(20).slice(0, 2) }) }));
  expect(features.map((feature) => feature.properties?.["role"])).toEqual(["area"]);
  const ring = (features[0]?.geometry as unknown as { coordinates: unknown[][] }).coordinates[0] ?? [];
  expect(ring).toHaveLength(5);
  expect(ring[0]).toEqual(ring[4]);
});

test.each([0.0005, 0.02, 0.4])(
  "the grid reaches beyond the edges of a map of ± %f degrees, with few lines",
  (reach) => {
    const map = new FakeMap();
    map.reach_deg = reach;
    map.attach(gridLayer).update(scene());
    const lines = map.sources.get("ground")?.data.features ?? [];
    const places = lines.flatMap(({ geometry }) => (geometry as LineString).coordinates);
    for (const [axis, middle] of [ORIGIN.longitude_deg, ORIGIN.latitude_deg].entries()) {
      const along = places.map((place) => place[axis] ?? NaN);
      expect(Math.min(...along)).toBeLessThan(middle - reach);
      expect(Math.max(...along)).toBeGreaterThan(middle + reach);
    }
    expect(lines.length).toBeGreaterThan(15);
    expect(lines.length).toBeLessThan(250);
  },
);

test("the grid is drawn again only where the map leaves it, and not for a whole country", () => {
  const map = new FakeMap();
  const grid = map.attach(gridLayer);
  const changes = () => map.sources.get("ground")?.changes;
  grid.update(scene());
  const before = changes();
  map.reach_deg *= 0.9;
  grid.update(scene());
  expect(changes()).toBe(before);
  map.reach_deg = 0.01;
  grid.update(scene());
  expect(changes()).toBe((before ?? 0) + 1);
  map.reach_deg = 5;
  grid.update(scene());
  expect(map.sources.get("ground")?.data.features).toEqual([]);
});

test("refused waypoints carry the reason, sent ones a path", () => {
  const requested = position(1, 1);
  const refused = step(1, {
    waypoints: [
      { vehicle_id: 1, requested, sent: requested, verdict: "sent", reason: "" },
      { vehicle_id: 2, requested, sent: null, verdict: "held", reason: "outside the fence" },
    ],
  });
  const shown = scene({
    mission: mission({ vehicles: [vehicle(1, { waypoint: position(5, 5) }), vehicle(2)] }),
    state: { ...INITIAL_STATE, latestStep: refused },
  });
  const features = drawn(waypointsLayer, shown);
  expect(features.map((feature) => feature.properties?.["role"])).toEqual(["sent", "path", "refused"]);
  expect(features.at(-1)?.properties?.["reason"]).toBe("Held: outside the fence");
});

test("targets have an ellipse where their uncertainty is known", () => {
  const error = { semi_major_m: 2, semi_minor_m: 1, heading_deg: 30 };
  const targets = [target({ ellipse: error }), target({ track_id: 2, ellipse: null })];
  const features = drawn(targetsLayer, scene({ mission: mission({ targets }) }));
  expect(features.map((feature) => feature.geometry.type)).toEqual(["Polygon", "Point", "Point"]);
});

test("places that are left for a later look are marked beside the targets", () => {
  const left_for_later = [{ position: position(4, 20, 0), person_confidence: 0.12 }];
  const features = drawn(targetsLayer, scene({ mission: mission({ targets: [target()], left_for_later }) }));
  expect(features.map((feature) => feature.properties?.["name"])).toEqual(["Target 1", "Left for later (12\u202f%)"]);
});

test("vehicles that are selected or need attention are prominent, the others' heights are a layer of its own", () => {
  const vehicles = [
    vehicle(1),
    vehicle(2),
    vehicle(3, { refusal: "outside the fence" }),
    vehicle(4, { link_age_s: 9 }),
  ];
  const shown = scene({ mission: mission({ vehicles }), selected: new Set([2]) });
  const features = drawn(
    vehiclesLayer(() => undefined),
    shown,
  );
  const prominent = features.filter((feature) => feature.properties?.["isProminent"]);
  expect(prominent.map((feature) => feature.properties?.["id"])).toEqual([2, 3, 4]);
  expect(drawn(heightsLayer, shown)).toHaveLength(1);
});

test("every fifth contour line is a thick one with its height above the sea", () => {
  const lines = [490, 495, 500, 505].map((altitude_amsl_m) => ({
    altitude_amsl_m,
    latitude_deg: [48.1, 48.2],
    longitude_deg: [14.3, 14.4],
  }));
  const features = drawn(contoursLayer({ interval_m: 5, spacing_m: 20, lines }), scene());
  expect(features.map((feature) => feature.properties?.["rank"])).toEqual([0, 0, 2, 0]);
  expect(features[2]?.properties?.["height"]).toBe("500\u202fm");
  expect((features[0]?.geometry as LineString).coordinates).toEqual([
    [14.3, 48.1],
    [14.4, 48.2],
  ]);
});

test("contour lines are thinned out by zoom, and those of whole hundreds stay", () => {
  const line = { altitude_amsl_m: 500, latitude_deg: [60, 60.1], longitude_deg: [14.3, 14.4] };
  const map = new FakeMap();
  map.attach(contoursLayer({ interval_m: 1, spacing_m: 20, lines: [line] }));
  const opacity = map.paints.get("contours-0")?.["line-opacity"] as unknown[];
  const [, , farthest, indexZoom, farther, allZoom, near] = opacity;
  expect(farthest).toEqual(["case", [">=", ["get", "rank"], 2], 0.8, 0]);
  expect(farther).toEqual(["case", [">=", ["get", "rank"], 1], 0.8, 0]);
  expect(near).toBe(0.8);
  // 20 m are 10 px where a pixel is 2 m wide; at 60 degrees north it is half as wide as at the equator.
  expect(allZoom).toBeCloseTo(Math.log2(78271.517 / 4), 3);
  expect(indexZoom).toBeCloseTo(Number(allZoom) - Math.log2(5), 6);
});

test("shading lies on four known corners, or nowhere", () => {
  const corner = { east_m: 0, north_m: 0, latitude_deg: 48, longitude_deg: 14 };
  const map = new FakeMap();
  const layer = shadingLayer("/shading.png", [corner, corner, corner, corner]);
  if (layer !== null) map.attach(layer).remove();
  expect(map.images).toEqual(["/shading.png"]);
  expect(map.layers).toEqual([]);
  expect(shadingLayer("/shading.png", [])).toBeNull();
  expect(shadingLayer("/shading.png", [corner, corner, corner, { ...corner, latitude_deg: null }])).toBeNull();
});
