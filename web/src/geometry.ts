/**
 * Conversion between ENU metres about the origin of the mission and WGS 84 degrees, and shapes on the ground. Pure
 * functions.
 */
import type { Geodetic, Place } from "./api/types";
import type { EnuPoint } from "./state/state";

export type LngLat = [number, number];

export const lngLat = ({ longitude_deg, latitude_deg }: Place): LngLat => [longitude_deg, latitude_deg];
export const placeAt = ([longitude_deg, latitude_deg]: LngLat): Place => ({ latitude_deg, longitude_deg });

const WGS84_A_M = 6378137;
const WGS84_E2 = 6.69437999014e-3;
const DEG = Math.PI / 180;

/** Metres per degree at the origin, north and east, from the ellipsoid's radii of curvature. */
function metresPerDegree(origin: Geodetic): { east: number; north: number } {
  const sin = Math.sin(origin.latitude_deg * DEG);
  const w2 = 1 - WGS84_E2 * sin * sin;
  const meridian_m = (WGS84_A_M * (1 - WGS84_E2)) / w2 ** 1.5 + origin.altitude_amsl_m;
  const normal_m = WGS84_A_M / Math.sqrt(w2) + origin.altitude_amsl_m;
  return { north: meridian_m * DEG, east: normal_m * Math.cos(origin.latitude_deg * DEG) * DEG };
}

/** Longitude and latitude of an ENU point; within a kilometre of the origin exact to some centimetres. */
export function toLngLat(origin: Geodetic, [east_m, north_m]: EnuPoint): LngLat {
  const scale = metresPerDegree(origin);
  return [origin.longitude_deg + east_m / scale.east, origin.latitude_deg + north_m / scale.north];
}

/** The inverse of {@link toLngLat}. */
export function toEnu(origin: Geodetic, [lng, lat]: LngLat): EnuPoint {
  const scale = metresPerDegree(origin);
  return [(lng - origin.longitude_deg) * scale.east, (lat - origin.latitude_deg) * scale.north];
}

/** Way between two places of a region: bearing clockwise from true north in [0, 360), and distance. */
export function bearingAndDistance(from: Place, to: Place): { bearing_deg: number; distance_m: number } {
  // The scale halfway between them, where the length of a degree of longitude is their mean.
  const middle_deg = (from.latitude_deg + to.latitude_deg) / 2;
  const scale = metresPerDegree({ latitude_deg: middle_deg, longitude_deg: 0, altitude_amsl_m: 0 });
  const turn_deg = ((to.longitude_deg - from.longitude_deg + 540) % 360) - 180;
  const [east_m, north_m] = [turn_deg * scale.east, (to.latitude_deg - from.latitude_deg) * scale.north];
  const bearing_deg = (Math.atan2(east_m, north_m) / DEG + 360) % 360;
  return { bearing_deg, distance_m: Math.hypot(east_m, north_m) };
}

/** Closed ring of points around a centre. */
export function circle([east_m, north_m]: EnuPoint, radius_m: number, corners = 48): EnuPoint[] {
  return Array.from({ length: corners + 1 }, (_, index) => {
    const angle = (2 * Math.PI * (index % corners)) / corners;
    return [east_m + radius_m * Math.cos(angle), north_m + radius_m * Math.sin(angle)] as const;
  });
}

/** Closed ring of points on an ellipse whose major axis has this heading, clockwise from north. */
export function ellipse(
  [east_m, north_m]: EnuPoint,
  axes: { semi_major_m: number; semi_minor_m: number; heading_deg: number },
): EnuPoint[] {
  const heading = (axes.heading_deg * Math.PI) / 180;
  return circle([0, 0], 1).map(([across, along]): EnuPoint => {
    const [right, ahead] = [across * axes.semi_minor_m, along * axes.semi_major_m];
    return [
      east_m + ahead * Math.sin(heading) + right * Math.cos(heading),
      north_m + ahead * Math.cos(heading) - right * Math.sin(heading),
    ];
  });
}

export interface Bounds {
  west_m: number;
  south_m: number;
  east_m: number;
  north_m: number;
}

/** Smallest box around the points, widened by a margin; null without points. */
export function boundsOf(points: readonly EnuPoint[], margin_m = 0): Bounds | null {
  if (points.length === 0) return null;
  const easts = points.map(([east_m]) => east_m);
  const norths = points.map(([, north_m]) => north_m);
  return {
    west_m: Math.min(...easts) - margin_m,
    south_m: Math.min(...norths) - margin_m,
    east_m: Math.max(...easts) + margin_m,
    north_m: Math.max(...norths) + margin_m,
  };
}

export interface GridLine {
  from: EnuPoint;
  to: EnuPoint;
  isMajor: boolean;
}

/** Smallest of the spacings 10, 20, 50, 100 m and so on that is not below this one. */
export function spacingOf(least_m: number): number {
  const power = 10 ** Math.max(1, Math.floor(Math.log10(least_m)));
  return [1, 2, 5].map((factor) => factor * power).find((spacing_m) => spacing_m >= least_m) ?? 10 * power;
}

/** Lines every `spacing_m` within the bounds, at whole multiples; every fifth is a major one. */
export function gridLines(bounds: Bounds, spacing_m: number): GridLine[] {
  const lines: GridLine[] = [];
  const indices = (low: number, high: number): number[] => {
    const first = Math.ceil(low / spacing_m);
    return Array.from({ length: Math.max(0, Math.floor(high / spacing_m) - first + 1) }, (_, i) => first + i);
  };
  for (const i of indices(bounds.west_m, bounds.east_m)) {
    const x = i * spacing_m;
    lines.push({ from: [x, bounds.south_m], to: [x, bounds.north_m], isMajor: i % 5 === 0 });
  }
  for (const i of indices(bounds.south_m, bounds.north_m)) {
    const y = i * spacing_m;
    lines.push({ from: [bounds.west_m, y], to: [bounds.east_m, y], isMajor: i % 5 === 0 });
  }
  return lines;
}
