/** What draws maps. It is most of the page's size, so it comes after the rest, and only where there is a map. */
import { Part } from "../ui/part";

export type { MapView } from "./view";

export const MAP_LIBRARY = new Part(() => import("./view"));
/** What reads base maps: only where there is one. */
export const BASEMAP_LIBRARY = new Part(() => import("./layers/basemap"));
