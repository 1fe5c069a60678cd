/** What has been searched, as the page shows it. */
import type { PictureKind } from "../api/types";
import type { State } from "./state";

/** Image of what has been searched: the probability of detection where the station knows it, else the views. */
export function searchedKind(pictures: State["pictures"]): PictureKind | null {
  if (pictures.detection !== undefined) return "detection";
  return pictures.views === undefined ? null : "views";
}
