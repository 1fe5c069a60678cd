/** Videos of the wall: the station makes one at a time, of its record. */
import type { Notation } from "../coordinates";
import { type Answer, request } from "./client";
import type { components } from "./schema";

export type Video = components["schemas"]["VideoModel"];

const PATH = "/api/wall/video";
export const VIDEO_URL = "/api/wall/video.mp4";

const isVideo = (value: unknown): value is Video =>
  typeof value === "object" &&
  value !== null &&
  typeof (value as { phase?: unknown }).phase === "string" &&
  typeof (value as { number?: unknown }).number === "number";

export const readVideo = (): Promise<Answer<Video>> => request("GET", PATH, isVideo);

/** Begin a video of these tiles; of all, where none are named. */
export const beginVideo = (tiles: readonly string[], notation: Notation): Promise<Answer<Video>> =>
  request("POST", PATH, isVideo, { tiles, notation });

/** End what is being made, or remove what is ready. */
export const giveUpVideo = (): Promise<Answer<Video>> => request("DELETE", PATH, isVideo);
