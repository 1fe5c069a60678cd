/** Requests about plans. */
import { type Answer, type Guard, request } from "./client";
import type { ImportedShape, Plan, PlanReport, SavedPlan, Strategy } from "./types";

const isObject = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null;
const isPlan = (value: unknown): value is Plan =>
  isObject(value) && typeof value["vehicles"] === "number" && Array.isArray(value["area"]);
const isReport = (value: unknown): value is PlanReport =>
  isObject(value) && Array.isArray(value["problems"]) && Array.isArray(value["proposals"]);
const isNothing = (value: unknown): value is null => value === null;
const isString = (value: unknown): value is string => typeof value === "string";
const listOf =
  <T>(isOne: Guard<T>): Guard<T[]> =>
  (value): value is T[] =>
    Array.isArray(value) && value.every(isOne);
const isStrategy = (value: unknown): value is Strategy =>
  isObject(value) && isString(value["name"]) && Array.isArray(value["parameters"]);
const isSavedPlan = (value: unknown): value is SavedPlan => isObject(value) && isString(value["name"]);
const isShape = (value: unknown): value is ImportedShape =>
  isObject(value) && isString(value["role"]) && Array.isArray(value["places"]);

const pathOf = (name: string): string => `/api/plans/${encodeURIComponent(name)}`;

/** Read the plan of the mission. */
export const readPlan = (): Promise<Answer<Plan>> => request("GET", "/api/plan", isPlan);

/** Check a plan: problems, estimate, and suggested values. */
export const checkPlan = (plan: Plan): Promise<Answer<PlanReport>> =>
  request("POST", "/api/plan/check", isReport, plan);

/** Apply a plan to the mission. */
export const applyPlan = (plan: Plan): Promise<Answer<Plan>> => request("POST", "/api/plan/apply", isPlan, plan);

/** Read the available strategies and their parameters. */
export const readStrategies = (): Promise<Answer<Strategy[]>> =>
  request("GET", "/api/plan/strategies", listOf(isStrategy));

/** Read the shapes of a file: GeoJSON, KML, or a plan of QGroundControl. */
export const importFile = (file: Blob): Promise<Answer<ImportedShape[]>> =>
  request("POST", "/api/plan/import", listOf(isShape), file);

export const listPlans = (): Promise<Answer<SavedPlan[]>> => request("GET", "/api/plans", listOf(isSavedPlan));
export const readSavedPlan = (name: string): Promise<Answer<Plan>> => request("GET", pathOf(name), isPlan);
/** Save a plan. `replaces` is the version of the saved plan to replace; null if there was none of that name. */
export const savePlan = (name: string, plan: Plan, replaces: string | null): Promise<Answer<Plan>> =>
  request("PUT", `${pathOf(name)}?replaces=${encodeURIComponent(replaces ?? "none")}`, isPlan, plan);
export const deletePlan = (name: string): Promise<Answer<null>> => request("DELETE", pathOf(name), isNothing);
