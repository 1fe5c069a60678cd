/** Requests about a recorded mission. */
import { type Answer, request } from "./client";
import type { Replay, ReplayRequest, Timeline } from "./types";

const isObject = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null;
const isReplay = (value: unknown): value is Replay => isObject(value) && typeof value["time_s"] === "number";
const isTimeline = (value: unknown): value is Timeline =>
  isObject(value) && isReplay(value["replay"]) && Array.isArray(value["phases"]) && Array.isArray(value["steps"]);

/** When each phase and step began. */
export const readTimeline = (): Promise<Answer<Timeline>> => request("GET", "/api/replay", isTimeline);

/** Go to a time, play or stop, for all clients; what is not given stays as it is. */
export const controlReplay = (change: ReplayRequest): Promise<Answer<Replay>> =>
  request("POST", "/api/replay", isReplay, change);
