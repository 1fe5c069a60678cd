/** The preflight checks as a matrix. Pure functions. */
import type { PreflightCheck } from "../../api/types";
import { capitalised } from "../../format";
import { texts } from "../../texts";

/** Stands for the mission as a whole in the place of a vehicle's number. */
export const MISSION_ID = 0;

export type Verdict = "pass" | "warn" | "fail" | "overridden";

export interface Matrix {
  /** Of the mission as a whole. */
  readonly mission: readonly PreflightCheck[];
  readonly names: readonly string[];
  readonly rows: readonly { readonly id: number; readonly checks: readonly (PreflightCheck | undefined)[] }[];
}

/** One row per vehicle, one column per check; these in the order of their first appearance. */
export function matrixOf(checks: readonly PreflightCheck[]): Matrix {
  const mission = checks.filter((check) => check.vehicle_id === MISSION_ID);
  const ofVehicles = checks.filter((check) => check.vehicle_id !== MISSION_ID);
  const names = [...new Set(ofVehicles.map((check) => check.name))];
  const ids = [...new Set(ofVehicles.map((check) => check.vehicle_id))].sort((a, b) => a - b);
  const find = (id: number, name: string): PreflightCheck | undefined =>
    ofVehicles.find((check) => check.vehicle_id === id && check.name === name);
  return { mission, names, rows: ids.map((id) => ({ id, checks: names.map((name) => find(id, name)) })) };
}

export function verdictOf({ status, overridden }: PreflightCheck): Verdict {
  return overridden === null ? status : "overridden";
}

export interface Blocker {
  readonly ids: number[];
  readonly name: string;
  readonly text: string;
  /** Of the first of these checks. */
  readonly key: string;
}

/** What stands against the launch; what is the same with several vehicles is said once. */
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

/** Whom a check concerns, in words. */
export function subjectOf(...ids: readonly number[]): string {
  const [first] = ids;
  if (first === MISSION_ID) return texts.prepare.mission;
  return `${ids.length === 1 ? texts.prepare.vehicle : texts.prepare.vehicles} ${ranges(ids)}`;
}

/** Numbers in order, those that follow each other as ranges: "1–4, 7". */
export function ranges(ids: readonly number[]): string {
  const runs: [number, number][] = [];
  for (const id of ids.toSorted((a, b) => a - b)) {
    const last = runs.at(-1);
    if (last !== undefined && id === last[1] + 1) last[1] = id;
    else runs.push([id, id]);
  }
  return runs.map(([from, to]) => (from === to ? `${from}` : `${from}–${to}`)).join(", ");
}

/** Display name of a check: the station names its checks in words. */
export const nameOf = (name: string): string => capitalised(name);
