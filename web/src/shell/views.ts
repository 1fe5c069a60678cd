/** Views of the page, in the order of a mission. Each is loaded when it is opened, and all before they could be missed. */
import type { ComponentType } from "preact";
import { BASEMAP_LIBRARY, MAP_LIBRARY } from "../map/library";
import { Part } from "../ui/part";
import { VIEW_NAMES, type ViewName } from "./route";

/** A view with a map needs what draws it as well: both are asked for at the same time, and the view is shown without it. */
const withMap = (): void => void MAP_LIBRARY.load();

export const VIEWS: Readonly<Record<ViewName, Part<ComponentType>>> = {
  plan: new Part(async () => (withMap(), (await import("../views/plan")).PlanView)),
  prepare: new Part(async () => (await import("../views/prepare")).PrepareView),
  fly: new Part(async () => (withMap(), (await import("../views/fly")).FlyView)),
  see: new Part(async () => (await import("../views/see")).SeeView),
  wall: new Part(async () => (await import("../views/wall")).WallView),
  understand: new Part(async () => (await import("../views/understand")).UnderstandView),
  decide: new Part(async () => (withMap(), (await import("../views/decide")).DecideView)),
};

/** Load what has not been opened yet: a view must not be missing when the station is out of reach. */
export async function loadAllViews(): Promise<void> {
  for (const library of [MAP_LIBRARY, BASEMAP_LIBRARY]) await library.load();
  for (const name of VIEW_NAMES) await VIEWS[name].load();
}
