/** Shapes of a plan, named like the fields of the station's plan. Pure functions. */
import type { ImportedShape, Place, Plan, Proposal, ShapeRole } from "../../api/types";

export type ShapeName = "area" | "fence" | "launch" | "return_point" | `no_go[${number}]`;

/** Whether a shape is a single point. */
export const isPoint = (shape: ShapeName): shape is "launch" | "return_point" =>
  shape === "launch" || shape === "return_point";

/** Index of a no-go zone; null for other shapes. */
export function noGoIndex(shape: ShapeName): number | null {
  const digits = /^no_go\[(\d+)\]$/.exec(shape)?.[1];
  return digits === undefined ? null : Number(digits);
}

/** All shapes of a plan, in the order of the page. */
export function shapeNames(plan: Plan): ShapeName[] {
  return ["area", ...plan.no_go.map((_, index) => `no_go[${index}]` as const), "launch", "return_point", "fence"];
}

/** Corners of a polygon, or the one place of a point; empty where the shape is not given. */
export function placesOf(plan: Plan, shape: ShapeName): readonly Place[] {
  if (shape === "area") return plan.area;
  if (shape === "fence") return plan.fence ?? [];
  if (shape === "launch" || shape === "return_point") {
    const place = plan[shape];
    return place ? [place] : [];
  }
  return plan.no_go[noGoIndex(shape) ?? -1] ?? [];
}

/** Plan with other places for one shape; points and geofence without places are left to the station. */
export function withPlaces(plan: Plan, shape: ShapeName, places: readonly Place[]): Plan {
  if (isPoint(shape)) return { ...plan, [shape]: places.at(-1) ?? null };
  if (shape === "fence") return { ...plan, fence: places.length === 0 ? null : [...places] };
  if (shape === "area") return { ...plan, area: [...places] };
  const changed = noGoIndex(shape);
  return { ...plan, no_go: plan.no_go.map((zone, index) => (index === changed ? [...places] : zone)) };
}

/** Plan with one more no-go zone, still without corners. */
export const withNoGo = (plan: Plan): Plan => ({ ...plan, no_go: [...plan.no_go, []] });

/** Plan without a shape. */
export function withoutShape(plan: Plan, shape: ShapeName): Plan {
  const removed = noGoIndex(shape);
  if (removed === null) return withPlaces(plan, shape, []);
  return { ...plan, no_go: plan.no_go.filter((_, index) => index !== removed) };
}

/** Places with one more before the given index. */
export const inserted = (places: readonly Place[], index: number, place: Place): Place[] => [
  ...places.slice(0, index),
  place,
  ...places.slice(index),
];
export const replaced = (places: readonly Place[], index: number, place: Place): Place[] =>
  places.map((before, i) => (i === index ? place : before));
export const removed = (places: readonly Place[], index: number): Place[] => places.filter((_, i) => i !== index);

/** Midpoints of the edges; empty where there is no edge. */
export function midpoints(places: readonly Place[]): Place[] {
  if (places.length < 2) return [];
  const ends = places.length === 2 ? places.slice(0, 1) : places;
  return ends.map((place, index) => {
    const next = places[(index + 1) % places.length] ?? place;
    return {
      latitude_deg: (place.latitude_deg + next.latitude_deg) / 2,
      longitude_deg: (place.longitude_deg + next.longitude_deg) / 2,
    };
  });
}

// --- from files

/** Role of an imported shape. */
export type ImportRole = ShapeRole | "skip";

/** Roles suggested by the station; of shapes that a plan has only once, later ones are ignored. */
export function proposedRoles(shapes: readonly ImportedShape[]): ImportRole[] {
  const taken = new Set<ShapeRole>();
  return shapes.map(({ role }) => {
    if (role !== "no_go" && taken.has(role)) return "skip";
    taken.add(role);
    return role;
  });
}

const POINT_ROLES: readonly ImportRole[] = ["launch", "return", "skip"];
const POLYGON_ROLES: readonly ImportRole[] = ["area", "no_go", "fence", "skip"];

/** Roles that an imported shape can have. */
export const rolesFor = ({ places }: ImportedShape): readonly ImportRole[] =>
  places.length === 1 ? POINT_ROLES : POLYGON_ROLES;

/** Plan with imported shapes: no-go zones are added, all other shapes are replaced. */
export function withImported(plan: Plan, shapes: readonly ImportedShape[], roles: readonly ImportRole[]): Plan {
  return shapes.reduce((taken, { places }, index) => {
    const role = roles[index] ?? "skip";
    if (role === "skip") return taken;
    if (role === "no_go") return { ...taken, no_go: [...taken.no_go, places] };
    return withPlaces(taken, role === "return" ? "return_point" : role, places);
  }, plan);
}

/** Plan with what an operator has taken over of a proposal; findings and dismissed ones change no plan. */
export function withProposal(plan: Plan, { name, places, use }: Pick<Proposal, "name" | "places" | "use">): Plan {
  if (use === null || use === "finding" || use === "dismissed") return plan;
  return withImported(plan, [{ name, places, role: use }], [use]);
}
