/** Preflight checks as a matrix. Pure functions. */
import type { PreflightCheck } from "../../api/types";
import { capitalised, ranges } from "../../format";
import { said, texts } from "../../texts";

/** Vehicle number of checks that concern the mission as a whole. */
const MISSION_ID = 0;

/** Status of a check as its cell shows it. */
export type CellStatus = "pass" | "warn" | "fail" | "overridden";

export interface Matrix {
  /** Checks of the mission as a whole. */
  readonly mission: readonly PreflightCheck[];
  readonly names: readonly string[];
  readonly rows: readonly { readonly id: number; readonly checks: readonly (PreflightCheck | undefined)[] }[];
}

/** Matrix with one row per vehicle and one column per check, in the order of their first appearance. */
export function matrixOf(checks: readonly PreflightCheck[]): Matrix {
  const mission = checks.filter((check) => check.vehicle_id === MISSION_ID);
  const ofVehicles = checks.filter((check) => check.vehicle_id !== MISSION_ID);
  const names = [...new Set(ofVehicles.map((check) => check.name))];
  const ids = [...new Set(ofVehicles.map((check) => check.vehicle_id))].sort((a, b) => a - b);
  const find = (id: number, name: string): PreflightCheck | undefined =>
    ofVehicles.find((check) => check.vehicle_id === id && check.name === name);
  return { mission, names, rows: ids.map((id) => ({ id, checks: names.map((name) => find(id, name)) })) };
}

/** Smallest width of a column with cells that fingers hit, and of the names beside them. */
const COLUMN_PX = 48;
const NAMES_PX = 64;

/** Whether the checks are the rows: where they are more than the vehicles, and would be cut as columns. */
export function areChecksRows({ names, rows }: Matrix, width_px: number): boolean {
  return rows.length < names.length && NAMES_PX + COLUMN_PX * names.length > width_px;
}

export function cellStatusOf({ status, overridden }: PreflightCheck): CellStatus {
  return overridden === null ? status : "overridden";
}

export interface Blocker {
  readonly ids: number[];
  readonly name: string;
  readonly text: string;
  /** Key of the first of these checks. */
  readonly key: string;
}

/** Checks that need to know which vehicles fly: they fail until that is confirmed. */
const OF_CONFIRMED: ReadonlySet<string> = new Set(["vehicles", "altitude layer", "geofence", "return height"]);

/** Checks that stay when some vehicles are confirmed: without those of others, and those that only wait for that. */
export const withoutConfirmation = (checks: readonly PreflightCheck[], ids: readonly number[]): PreflightCheck[] =>
  checks.filter(({ vehicle_id: id, name }) => (id === MISSION_ID || ids.includes(id)) && !OF_CONFIRMED.has(name));

/** Keys of the checks that warn. */
export const warningsOf = (checks: readonly PreflightCheck[]): ReadonlySet<string> =>
  new Set(checks.filter(({ status }) => status === "warn").map(keyOf));

/** Checks that block the launch; vehicles with the same issue share an entry. */
export function blockersOf(checks: readonly PreflightCheck[]): Blocker[] {
  const blockers: Blocker[] = [];
  for (const check of checks.filter(({ blocks }) => blocks)) {
    const same = blockers.find(({ name, text }) => name === check.name && text === check.text);
    if (same) same.ids.push(check.vehicle_id);
    else blockers.push({ ids: [check.vehicle_id], name: check.name, text: check.text, key: keyOf(check) });
  }
  return blockers;
}

export const keyOf = ({ vehicle_id: id, name }: PreflightCheck): string => `${id} ${name}`;

/** Subject of a check: vehicles, or the mission. */
export function subjectOf(...ids: readonly number[]): string {
  const [first] = ids;
  if (first === MISSION_ID) return texts.prepare.mission;
  return `${ids.length === 1 ? texts.prepare.vehicle : texts.prepare.vehicles} ${ranges(ids)}`;
}

/** Display name of a check: the station names its checks in words. */
export const nameOf = (name: string): string => capitalised(said(name));
