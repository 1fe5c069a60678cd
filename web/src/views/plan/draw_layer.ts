/** Map layer that shows the plan and edits it by mouse and touch: corners are added, moved and inserted. */
import type { Feature, Geometry } from "geojson";
import type { Map as MapLibreMap, MapMouseEvent, MapTouchEvent, PointLike } from "maplibre-gl";
import type { Place, Plan, PlanEstimate, PlanReport } from "../../api/types";
import { type LngLat, lngLat, placeAt } from "../../geometry";
import { feature } from "../../map/geojson";
import { type AttachedLayer, featureLayer, type MapLayer } from "../../map/layer";
import { texts } from "../../texts";
import { inserted, isPoint, midpoints, noGoIndex, placesOf, replaced, type ShapeName, shapeNames } from "./shapes";

/** Plan with the state of its editing. */
export interface Drawing {
  readonly plan: Plan;
  readonly legs: PlanEstimate["legs"];
  /** Index of the leg whose profile is shown. */
  readonly leg: number;
  /** Geofence by the station, the one that it proposes where the plan has none. */
  readonly fence: PlanReport["fence"];
  readonly shape: ShapeName;
  /** Selected corner of the selected shape. */
  readonly vertex: number | null;
  /** Whether clicks add corners. */
  readonly isDrawing: boolean;
  readonly isEditable: boolean;
}

export interface DrawingEvents {
  onPlaces(places: readonly Place[], vertex: number): void;
  onVertex(vertex: number): void;
  onShape(shape: ShapeName): void;
  onFinish(): void;
}

const ID = "draft";
/** Largest distance between a pointer and a corner that it grips; a finger is broader than a mouse pointer. */
const REACH_PX = { mouse: 10, touch: 24 };

const has = (role: string): ["==", ["get", string], string] => ["==", ["get", "role"], role];

/** Make the layer, once: `drawing` is read at every update. */
export function drawLayer(drawing: () => Drawing | null, events: DrawingEvents): MapLayer {
  const features = featureLayer({
    id: ID,
    paint: (palette) => [
      { type: "fill", filter: has("no-go"), paint: { "fill-color": palette.fence, "fill-opacity": 0.25 } },
      { type: "fill", filter: has("area"), paint: { "fill-color": palette.area, "fill-opacity": 0.1 } },
      {
        type: "line",
        filter: has("leg"),
        paint: { "line-color": palette.area, "line-width": ["case", ["get", "isChosen"], 3, 1], "line-opacity": 0.8 },
      },
      { type: "line", filter: has("no-go"), paint: { "line-color": palette.fence, "line-width": 2 } },
      { type: "line", filter: has("area"), paint: { "line-color": palette.area, "line-width": 2 } },
      {
        type: "line",
        filter: has("fence"),
        paint: { "line-color": palette.fence, "line-width": 2, "line-dasharray": [4, 2] },
      },
      {
        type: "circle",
        filter: has("point"),
        paint: {
          "circle-radius": 8,
          "circle-color": palette.home,
          "circle-stroke-color": palette.halo,
          "circle-stroke-width": 2,
        },
      },
      {
        type: "symbol",
        filter: has("point"),
        layout: { "text-field": ["get", "name"], "text-size": 13, "text-anchor": "left", "text-offset": [1, 0] },
        paint: { "text-color": palette.label, "text-halo-color": palette.halo, "text-halo-width": 1.5 },
      },
      {
        type: "circle",
        filter: has("middle"),
        paint: {
          "circle-radius": 5,
          "circle-color": palette.background,
          "circle-stroke-color": palette.selected,
          "circle-stroke-width": 1.5,
          "circle-opacity": 0.8,
        },
      },
      {
        type: "circle",
        filter: has("vertex"),
        paint: {
          "circle-radius": ["case", ["get", "isChosen"], 10, 7],
          "circle-color": ["case", ["get", "isChosen"], palette.target, palette.selected],
          "circle-stroke-color": palette.halo,
          "circle-stroke-width": 2,
        },
      },
    ],
    inputs: () => {
      const shown = drawing();
      return [shown?.plan, shown?.legs, shown?.leg, shown?.fence, shown?.shape, shown?.vertex, shown?.isEditable];
    },
    features: () => {
      const shown = drawing();
      return shown === null ? [] : draftFeatures(shown);
    },
  });
  return {
    id: ID,
    attach(map, palette) {
      const attached = features.attach(map, palette);
      const stop = followPointer(map, drawing, events);
      return {
        update(scene) {
          attached.update(scene);
          map.getCanvas().style.cursor = drawing()?.isDrawing ? "crosshair" : "";
        },
        remove() {
          stop();
          map.getCanvas().style.cursor = "";
          attached.remove();
        },
      } satisfies AttachedLayer;
    },
  };
}

/** Features of a plan on the map. */
export function draftFeatures({ plan, legs, leg, fence, shape: chosen, vertex, isEditable }: Drawing): Feature[] {
  const shapes = shapeNames(plan).flatMap((shape) => shapeFeatures(shape, placesOf(plan, shape)));
  const legLines = legs.flatMap(({ start, end }, index): Feature[] => {
    const ends = [start, end].flatMap(({ longitude_deg: lng, latitude_deg: lat }): LngLat[] =>
      lng === null || lat === null ? [] : [[lng, lat]],
    );
    return ends.length < 2
      ? []
      : [feature({ type: "LineString", coordinates: ends }, { role: "leg", isChosen: index === leg })];
  });
  if (plan.fence === null) shapes.push(...proposedFence(fence));
  if (!isEditable) return [...legLines, ...shapes];
  const places = placesOf(plan, chosen);
  const handles = places.map((place, index) => handle(place, { role: "vertex", isChosen: index === vertex }));
  const middles = isPoint(chosen) ? [] : midpoints(places).map((place) => handle(place, { role: "middle" }));
  return [...legLines, ...shapes, ...middles, ...handles];
}

const handle = (place: Place, properties: Record<string, unknown>): Feature =>
  feature({ type: "Point", coordinates: lngLat(place) }, properties);

/** Geofence that is proposed: drawn like a set one, but no shape that can be chosen. */
function proposedFence(fence: readonly Place[]): Feature[] {
  const [first] = fence;
  if (first === undefined) return [];
  return [feature({ type: "Polygon", coordinates: [[...fence, first].map(lngLat)] }, { role: "fence" })];
}

function shapeFeatures(shape: ShapeName, places: readonly Place[]): Feature[] {
  const [first] = places;
  if (first === undefined) return [];
  if (isPoint(shape)) return [handle(first, { role: "point", shape, name: texts.plan.shape[shape] })];
  const role = noGoIndex(shape) === null ? shape : "no-go";
  const corners = places.map(lngLat);
  // Two corners are drawn as a line until there is a third.
  const geometry: Geometry =
    corners.length < 3
      ? { type: "LineString", coordinates: corners }
      : { type: "Polygon", coordinates: [[...corners, lngLat(first)]] };
  return corners.length < 2 ? [] : [feature(geometry, { role, shape })];
}

// --- pointer

interface Drag {
  readonly places: readonly Place[];
  readonly index: number;
}

/** Edit the drawing by pointer; returns a function that stops it. */
function followPointer(map: MapLibreMap, drawing: () => Drawing | null, events: DrawingEvents): () => void {
  let drag: Drag | null = null;

  const grip = (event: MapMouseEvent | MapTouchEvent, reach_px: number): void => {
    const shown = drawing();
    if (!shown?.isEditable) return;
    const places = placesOf(shown.plan, shown.shape);
    const index = nearest(map, places, event, reach_px);
    if (index !== null) drag = { places, index };
    else if (!isPoint(shown.shape)) {
      const middles = midpoints(places);
      const before = nearest(map, middles, event, reach_px);
      const middle = before === null ? undefined : middles[before];
      if (before !== null && middle) drag = { places: inserted(places, before + 1, middle), index: before + 1 };
    }
    if (drag === null) return;
    event.preventDefault(); // keeps the map in place
    events.onVertex(drag.index);
  };
  const move = (event: MapMouseEvent | MapTouchEvent): void => {
    if (drag === null) return;
    const place = placeAt([event.lngLat.lng, event.lngLat.lat]);
    events.onPlaces(replaced(drag.places, drag.index, place), drag.index);
  };
  const release = (): void => {
    drag = null;
  };
  const click = (event: MapMouseEvent): void => {
    const shown = drawing();
    if (shown === null) return;
    if (!shown.isDrawing) chooseShape(event);
    else if (event.originalEvent.detail <= 1) addCorner(shown, event);
  };
  const chooseShape = (event: MapMouseEvent): void => {
    const [hit] = map.queryRenderedFeatures(event.point).filter(({ source }) => source === ID);
    const shape: unknown = hit?.properties["shape"];
    if (typeof shape === "string") events.onShape(shape as ShapeName);
  };
  const addCorner = (shown: Drawing, event: MapMouseEvent): void => {
    const places = placesOf(shown.plan, shown.shape);
    const at = isPoint(shown.shape) ? null : nearest(map, places, event, REACH_PX.mouse);
    if (at === 0 && places.length > 2) events.onFinish();
    if (at !== null) return;
    events.onPlaces([...places, placeAt([event.lngLat.lng, event.lngLat.lat])], places.length);
    if (isPoint(shown.shape)) events.onFinish();
  };
  const finish = (event: MapMouseEvent): void => {
    if (!drawing()?.isDrawing) return;
    event.preventDefault(); // prevents zooming
    events.onFinish();
  };

  const subscriptions = [
    map.on("mousedown", (event) => grip(event, REACH_PX.mouse)),
    map.on("touchstart", (event) => event.points.length === 1 && grip(event, REACH_PX.touch)),
    map.on("mousemove", move),
    map.on("touchmove", move),
    map.on("mouseup", release),
    map.on("touchend", release),
    map.on("touchcancel", release),
    map.on("click", click),
    map.on("dblclick", finish),
  ];
  return () => subscriptions.forEach((subscription) => subscription.unsubscribe());
}

/** Index of the place nearest to the pointer within reach, or null. */
function nearest(
  map: MapLibreMap,
  places: readonly Place[],
  { point }: { point: PointLike & { x: number; y: number } },
  reach_px: number,
): number | null {
  let best: number | null = null;
  let best_px = reach_px;
  places.forEach((place, index) => {
    const at = map.project(lngLat(place));
    const distance_px = Math.hypot(at.x - point.x, at.y - point.y);
    if (distance_px <= best_px) [best, best_px] = [index, distance_px];
  });
  return best;
}
