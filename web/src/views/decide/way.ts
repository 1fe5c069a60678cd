/** Way to a finding from a place that the searchers know: the launch site, or one that they have set. */
import type { Finding, Mission, Place } from "../../api/types";
import { bearing, distance } from "../../format";
import { bearingAndDistance, placeAt, toLngLat } from "../../geometry";
import { readStored, store } from "../../storage";
import { texts } from "../../texts";

const KEY = "aos-gcs-reference-place";

/** Place that operators have set on this screen; null for the launch site. */
export type Reference = Place | null;

export function storedReference(): Reference {
  try {
    const stored: unknown = JSON.parse(readStored(KEY) ?? "null");
    return isPlace(stored) ? stored : null;
  } catch {
    return null; // not written by this page
  }
}

export function storeReference(place: Reference): void {
  if (place === null) store(KEY, null);
  else store(KEY, JSON.stringify(place));
}

const isPlace = (value: unknown): value is Place =>
  typeof value === "object" &&
  value !== null &&
  "latitude_deg" in value &&
  typeof value.latitude_deg === "number" &&
  "longitude_deg" in value &&
  typeof value.longitude_deg === "number";

/** Middle of the launch points, or the origin before a vehicle has reported its own; null before that. */
export function launchSite({ vehicles, origin }: Pick<Mission, "vehicles" | "origin">): Place | null {
  if (origin === null) return null;
  const homes = vehicles.flatMap(({ home }) => (home === null ? [] : [home]));
  if (homes.length === 0) return origin;
  const mean = (values: readonly number[]): number => values.reduce((sum, value) => sum + value, 0) / values.length;
  return placeAt(toLngLat(origin, [mean(homes.map((home) => home.east_m)), mean(homes.map((home) => home.north_m))]));
}

/** Bearing and distance of a finding in words: "283° true, 41 m from the launch site"; null where a place is unknown. */
export function wayTo(finding: Finding, mission: Mission, reference: Reference): string | null {
  const from = reference ?? launchSite(mission);
  const { latitude_deg, longitude_deg } = finding.position;
  if (from === null || latitude_deg === null || longitude_deg === null) return null;
  const { bearing_deg, distance_m } = bearingAndDistance(from, { latitude_deg, longitude_deg });
  const words = reference === null ? texts.decide.fromLaunch : texts.decide.fromPlace;
  return words(bearing(bearing_deg), distance(distance_m));
}
