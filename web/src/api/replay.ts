/** Requests about a recorded mission. */
import { type Answer, request } from "./client";
import type { Replay, ReplayRequest, Timeline } from "./types";

const isObject = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null;
const isReplay = (value: unknown): value is Replay => isObject(value) && typeof value["time_s"] === "number";
const isTimeline = (value: unknown): value is Timeline =>
  isObject(value) && isReplay(value["replay"]) && Array.isArray(value["phases"]) && Array.isArray(value["steps"]);

/** Times at which each phase and step began, with notices and findings. */
export const readTimeline = (): Promise<Answer<Timeline>> => request("GET", "/api/replay", isTimeline);

/** Seek, play or pause for all clients; values that are not given stay. */
export const controlReplay = (change: ReplayRequest): Promise<Answer<Replay>> =>
  request("POST", "/api/replay", isReplay, change);
