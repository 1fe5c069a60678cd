/** Requests about findings; the list itself is part of the state of the mission. */
import { type Answer, request } from "./client";
import type { Finding, FindingChange, Place } from "./types";

const isFinding = (value: unknown): value is Finding =>
  typeof value === "object" && value !== null && "finding_id" in value && typeof value.finding_id === "number";

/** Confirm, reject, comment or assign a finding; fields that are not given stay. */
export const changeFinding = (id: number, change: Partial<FindingChange>): Promise<Answer<Finding>> =>
  request("PATCH", `/api/findings/${id}`, isFinding, change);

/** Mark a position. */
export const addFinding = (place: Place, comment: string): Promise<Answer<Finding>> =>
  request("POST", "/api/findings", isFinding, { ...place, comment });

/** What the image of a finding shows. */
export interface Shot {
  readonly kind: "integral" | "thermal";
  /** Height of the focal plane above the finding. */
  readonly above_m?: number;
  /** Whether only the frame of the nearest camera is shown instead of the integral of all. */
  readonly isNearest?: boolean;
}

/** Address of the image around a finding at the step that showed it last. */
export function thumbnailUrl(
  { finding_id, step, found_in }: Finding,
  { kind, above_m = 0, isNearest = false }: Shot,
): string {
  const query = new URLSearchParams({ step: `${step}` });
  if (found_in !== "") query.set("found_in", found_in);
  if (above_m !== 0) query.set("above_m", `${above_m}`);
  if (isNearest) query.set("nearest", "true");
  return `/api/findings/${finding_id}/${kind}.png?${query.toString()}`;
}

export const FINDING_FILES = ["geojson", "kml", "kmz", "gpx"] as const;

/** Address of the file by which Google Earth and CalTopo follow the mission. */
export const NETWORK_LINK_URL = "/api/network-link.kml";
export const findingsFileUrl = (suffix: (typeof FINDING_FILES)[number]): string => `/api/findings.${suffix}`;
