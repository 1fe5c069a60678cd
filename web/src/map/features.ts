/** The mission as GeoJSON. Pure functions; `role` tells the layers apart. */
import type { Feature, FeatureCollection, Geometry } from "geojson";
import type { Geodetic, Mission, Position, Step } from "../api/types";
import { boundsOf, ellipse, gridLines, toLngLat } from "../geometry";
import type { EnuPoint, State } from "../state/state";

export type Role =
  "grid" | "grid-major" | "area" | "fence" | "home" | "trail" | "plan" | "waypoint" | "refused" | "sigma";

const GRID_MARGIN_M = 400;
const GRID_SPACING_M = 10;
const GRID_MAX_LINES = 240;

const enu = (position: Position): EnuPoint => [position.east_m, position.north_m];

function feature(role: Role, geometry: Geometry, vehicleId?: number): Feature {
  return { type: "Feature", geometry, properties: { role, ...(vehicleId === undefined ? {} : { id: vehicleId }) } };
}

function collection(features: Feature[]): FeatureCollection {
  return { type: "FeatureCollection", features };
}

const line = (origin: Geodetic, points: readonly EnuPoint[]): Geometry => ({
  type: "LineString",
  coordinates: points.map((point) => toLngLat(origin, point)),
});
const point = (origin: Geodetic, place: EnuPoint): Geometry => ({
  type: "Point",
  coordinates: toLngLat(origin, place),
});
const polygon = (origin: Geodetic, ring: readonly EnuPoint[]): Geometry => ({
  type: "Polygon",
  coordinates: [[...ring, ...ring.slice(0, 1)].map((corner) => toLngLat(origin, corner))],
});

/** What stays the same during a mission: grid, search area, fence, launch points. */
export function fixedFeatures(origin: Geodetic, mission: Mission): FeatureCollection {
  const area = mission.area.map((corner): EnuPoint => [corner.east_m, corner.north_m]);
  const fence = mission.fence.map((corner): EnuPoint => [corner.east_m, corner.north_m]);
  const homes = mission.vehicles.flatMap(({ vehicle_id: id, home }) => (home === null ? [] : [{ id, home }]));
  const bounds = boundsOf([...area, ...fence, [0, 0]], GRID_MARGIN_M);
  let spacing_m = GRID_SPACING_M;
  while (bounds !== null && (2 * (bounds.east_m - bounds.west_m)) / spacing_m > GRID_MAX_LINES) spacing_m *= 2;
  const grid = bounds === null ? [] : gridLines(bounds, spacing_m);
  return collection([
    ...grid.map(({ from, to, isMajor }) => feature(isMajor ? "grid-major" : "grid", line(origin, [from, to]))),
    ...(area.length > 2 ? [feature("area", polygon(origin, area))] : []),
    ...(fence.length > 2 ? [feature("fence", polygon(origin, fence))] : []),
    ...homes.map(({ id, home }) => feature("home", point(origin, enu(home)), id)),
  ]);
}

/** Changes whenever {@link fixedFeatures} would. */
export function fixedKey(mission: Mission): string {
  return JSON.stringify([mission.origin, mission.area, mission.fence, mission.vehicles.map((vehicle) => vehicle.home)]);
}

/** What moves: trails, planned and refused waypoints, the target's uncertainty. */
export function movingFeatures(origin: Geodetic, mission: Mission, state: State): FeatureCollection {
  const features: Feature[] = [];
  for (const [id, trail] of state.trails) {
    if (trail.length > 1) features.push(feature("trail", line(origin, trail), id));
  }
  for (const { vehicle_id: id, position, waypoint } of mission.vehicles) {
    if (waypoint === null) continue;
    features.push(feature("waypoint", point(origin, enu(waypoint)), id));
    if (position !== null) features.push(feature("plan", line(origin, [enu(position), enu(waypoint)]), id));
  }
  for (const refused of refusedWaypoints(state.steps.at(-1))) {
    features.push(feature("refused", point(origin, enu(refused.requested)), refused.vehicle_id));
  }
  for (const { position, ellipse: error } of mission.targets) {
    if (error !== null) features.push(feature("sigma", polygon(origin, ellipse(enu(position), error))));
  }
  return collection(features);
}

function refusedWaypoints(step: Step | undefined): Step["waypoints"] {
  return step?.waypoints.filter((waypoint) => waypoint.verdict !== "sent") ?? [];
}

/** The points that "fit to fleet" shows: vehicles, their waypoints and the search area. */
export function fleetPoints(mission: Mission): EnuPoint[] {
  const moving = mission.vehicles.flatMap(({ position, waypoint }) => [position, waypoint]);
  return [
    ...moving.filter((place): place is Position => place !== null).map(enu),
    ...mission.area.map((corner): EnuPoint => [corner.east_m, corner.north_m]),
  ];
}
