/** Requests about recorded steps: other focal planes and single frames. */
import type { Bounds } from "../geometry";
import { texts } from "../texts";
import { type Answer, refused, request } from "./client";
import type { FocusFound, FrameKind, ViewedStep, ViewKind } from "./types";

const isObject = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null;
const isViewedStep = (value: unknown): value is ViewedStep =>
  isObject(value) && Array.isArray(value["kinds"]) && Array.isArray(value["frames"]);
const isFocusFound = (value: unknown): value is FocusFound => isObject(value) && typeof value["found"] === "boolean";

/** Integral image with its bounds on the ground. */
export interface Integral {
  readonly picture: Blob;
  readonly bounds: Bounds;
  readonly height_m: number;
  /** Area of the largest blob on this plane. */
  readonly visibility_m2: number;
}

/** Read which images and frames of a step are recorded. */
export const describeStep = (step: number): Promise<Answer<ViewedStep>> =>
  request("GET", `/api/viewer/${step}`, isViewedStep);

/** Find the height with the sharpest image of a square area. */
export function findFocus(
  step: number,
  [east_m, north_m]: readonly [number, number],
  half_width_m: number,
): Promise<Answer<FocusFound>> {
  const query = new URLSearchParams(
    Object.entries({ east_m, north_m, half_width_m }).map(([name, value]): [string, string] => [name, String(value)]),
  );
  return request("GET", `/api/viewer/${step}/autofocus?${query.toString()}`, isFocusFound);
}

/** Frame of a vehicle at a step of a mission. */
export interface FrameName {
  readonly missionId: string;
  readonly step: number;
  readonly vehicleId: number;
  readonly kind: FrameKind;
}

/** Address of a frame, scaled to a width if one is given; browsers keep what they have read of it. */
export function frameUrl({ missionId, step, vehicleId, kind }: FrameName, width_px?: number): string {
  const query = new URLSearchParams({ mission_id: missionId });
  if (width_px !== undefined) query.set("width_px", String(width_px));
  return `/api/viewer/${step}/frames/${vehicleId}/${kind}.png?${query.toString()}`;
}

export interface IntegralQuery {
  readonly step: number;
  readonly kind: ViewKind;
  /** Null for the plane of the mission. */
  readonly height_m: number | null;
  /** Whether a small and fast approximation is enough. */
  readonly isDraft: boolean;
}

/** Images of few colours: they are small as they are, and a draft would blur their counts. */
const COUNTS: ReadonlySet<ViewKind> = new Set(["anomaly", "coverage"]);

/** Read the integral of the frames of a step on a horizontal plane. */
export async function readIntegral({ step, kind, height_m, isDraft }: IntegralQuery): Promise<Answer<Integral>> {
  const format = isDraft && !COUNTS.has(kind) ? "jpg" : "png";
  const query = height_m === null ? "" : `?height_m=${height_m}`;
  try {
    const response = await fetch(`/api/viewer/${step}/integrals/${kind}.${format}${query}`);
    if (!response.ok) return await refused(response);
    const bounds = parseBounds(response.headers.get("X-Bounds-M"));
    if (bounds === null) return { ok: false, message: texts.requests.unreadableAnswer };
    const value = (name: string): number => Number(response.headers.get(name) ?? NaN);
    const picture = await response.blob();
    const [shown_m, visibility_m2] = [value("X-Height-M"), value("X-Visibility-M2")];
    return { ok: true, value: { picture, bounds, height_m: shown_m, visibility_m2 } };
  } catch {
    return { ok: false, message: texts.requests.notSent };
  }
}

/** West, south, east and north in metres from the header; null if it is malformed. */
export function parseBounds(header: string | null): Bounds | null {
  const [west_m, south_m, east_m, north_m, ...more] = (header ?? "").split(",").map(Number);
  if (west_m === undefined || south_m === undefined || east_m === undefined || north_m === undefined) return null;
  const isBox = west_m < east_m && south_m < north_m && more.length === 0;
  return isBox ? { west_m, south_m, east_m, north_m } : null;
}
