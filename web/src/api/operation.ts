/** Requests about the operation that the shown mission belongs to. */
import { type Answer, request } from "./client";
import type { Operation } from "./types";

const isOperation = (value: unknown): value is Operation =>
  typeof value === "object" && value !== null && Array.isArray((value as { sorties?: unknown }).sorties);

/** Sorties of the operation, the shown mission among them. */
export const readOperation = (): Promise<Answer<Operation>> => request("GET", "/api/operation", isOperation);
