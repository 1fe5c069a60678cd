/** Requests about the relief of the ground. */
import { type Answer, request } from "./client";
import type { Contours, Relief } from "./types";

const isRelief = (value: unknown): value is Relief =>
  typeof value === "object" && value !== null && "shading_url" in value && "corners" in value;
const isContours = (value: unknown): value is Contours =>
  typeof value === "object" && value !== null && "lines" in value && Array.isArray(value.lines);

/** Read where the pictures of the relief about the mission are. */
export const readRelief = (): Promise<Answer<Relief>> => request("GET", "/api/relief", isRelief);

/** Read contour lines. */
export const readContours = (url: string): Promise<Answer<Contours>> => request("GET", url, isContours);
