/** Views of the page, in the order of a mission. */
import type { ComponentType } from "preact";
import { DecideView } from "../views/decide";
import { FlyView } from "../views/fly";
import { PlanView } from "../views/plan";
import { PrepareView } from "../views/prepare";
import { SeeView } from "../views/see";
import { UnderstandView } from "../views/understand";
import { WallView } from "../views/wall";
import type { ViewName } from "./route";

export const VIEWS: Readonly<Record<ViewName, ComponentType>> = {
  plan: PlanView,
  prepare: PrepareView,
  fly: FlyView,
  see: SeeView,
  wall: WallView,
  understand: UnderstandView,
  decide: DecideView,
};
