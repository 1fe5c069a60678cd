/** GeoJSON from points in the ENU frame of the mission. */
import type { Feature, Geometry } from "geojson";
import type { Geodetic, Position, Vertex } from "../api/types";
import { toLngLat } from "../geometry";
import type { EnuPoint } from "../state/state";

export const enu = ({ east_m, north_m }: Position | Vertex): EnuPoint => [east_m, north_m];

export function feature(geometry: Geometry, properties: Record<string, unknown> = {}): Feature {
  return { type: "Feature", geometry, properties };
}

export const point = (origin: Geodetic, place: EnuPoint): Geometry => ({
  type: "Point",
  coordinates: toLngLat(origin, place),
});

export const line = (origin: Geodetic, points: readonly EnuPoint[]): Geometry => ({
  type: "LineString",
  coordinates: points.map((place) => toLngLat(origin, place)),
});

/** Polygon from its corners, with the ring closed. */
export const polygon = (origin: Geodetic, corners: readonly EnuPoint[]): Geometry => ({
  type: "Polygon",
  coordinates: [[...corners, ...corners.slice(0, 1)].map((corner) => toLngLat(origin, corner))],
});
