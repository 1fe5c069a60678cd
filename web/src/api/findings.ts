/** Requests about findings; the list itself comes with the mission's state. */
import { type Answer, request } from "./client";
import type { Finding, FindingChange, Place } from "./types";

const isFinding = (value: unknown): value is Finding =>
  typeof value === "object" && value !== null && "finding_id" in value && typeof value.finding_id === "number";

/** Confirm, reject, comment or assign; what is not named stays. */
export const changeFinding = (id: number, change: Partial<FindingChange>): Promise<Answer<Finding>> =>
  request("PATCH", `/api/findings/${id}`, isFinding, change);

/** Mark a place by hand. */
export const addFinding = (place: Place, comment: string): Promise<Answer<Finding>> =>
  request("POST", "/api/findings", isFinding, { ...place, comment });

/** The surroundings of a finding at the step that has shown it last. */
export const thumbnailUrl = ({ finding_id, step }: Finding, kind: "integral" | "thermal"): string =>
  `/api/findings/${finding_id}/${kind}.png?step=${step}`;

export const FINDING_FILES = ["geojson", "kml", "gpx"] as const;
export const findingsFileUrl = (suffix: (typeof FINDING_FILES)[number]): string => `/api/findings.${suffix}`;
