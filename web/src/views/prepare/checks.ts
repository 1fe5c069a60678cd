/** The preflight checks as a matrix. Pure functions. */
import type { PreflightCheck } from "../../api/types";
import { words } from "../../format";
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

export const keyOf = ({ vehicle_id: id, name }: PreflightCheck): string => `${id} ${name}`;

/** Whom a check concerns, in words. */
export function subjectOf(id: number): string {
  return id === MISSION_ID ? texts.prepare.mission : `${texts.prepare.vehicle} ${id}`;
}

/** A check's name in words. */
export const nameOf = (name: string): string => words(name);
