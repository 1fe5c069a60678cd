/** Profile of a leg as lines of a chart. Pure. */
import type { LegProfile } from "../../api/types";

type Heights = readonly (number | null)[];

/** Lines of a profile, in metres above the origin, bottom up. */
export interface ProfileLines {
  readonly distances_m: readonly number[];
  readonly lowestGround_m: Heights;
  readonly highestGround_m: Heights;
  /** Null where the plan states no forest. */
  readonly canopy_m: Heights | null;
  readonly floor_m: Heights;
  readonly layers_m: readonly Heights[];
  readonly ceiling_m: Heights;
}

/** Least and greatest distance of the layers from the ground, null where no ground is known. */
export interface Clearance {
  readonly lowest_m: number | null;
  readonly highest_m: number | null;
  /** Whether the lowest layer is below the floor, or the highest above the ceiling, somewhere. */
  readonly isBelowFloor: boolean;
  readonly isAboveCeiling: boolean;
}

export interface Scale {
  readonly width_px: number;
  readonly height_px: number;
  readonly length_m: number;
  readonly bottom_m: number;
  readonly top_m: number;
}

const sum = (heights: Heights, offset_m: number): Heights =>
  heights.map((height_m) => (height_m === null ? null : height_m + offset_m));

export function profileLines(
  profile: LegProfile,
  layers_m: readonly number[],
  canopyHeight_m: number | null,
): ProfileLines {
  return {
    distances_m: profile.distance_m,
    lowestGround_m: profile.lowest_ground_m,
    highestGround_m: profile.highest_ground_m,
    canopy_m: canopyHeight_m === null ? null : sum(profile.highest_ground_m, canopyHeight_m),
    floor_m: profile.floor_m,
    layers_m: layers_m.map((layer_m) => sum(profile.surface_m, layer_m)),
    ceiling_m: profile.ceiling_m,
  };
}

/** How close the layers come to the ground, and how far they are above it. */
export function clearanceOf({
  lowestGround_m,
  highestGround_m,
  layers_m,
  floor_m,
  ceiling_m,
}: ProfileLines): Clearance {
  const [lowest, highest] = [layers_m[0] ?? [], layers_m.at(-1) ?? []];
  const above = difference(lowest, highestGround_m);
  const far = difference(highest, lowestGround_m);
  return {
    lowest_m: above.length > 0 ? Math.min(...above) : null,
    highest_m: far.length > 0 ? Math.max(...far) : null,
    isBelowFloor: difference(lowest, floor_m).some((room_m) => room_m < 0),
    isAboveCeiling: difference(ceiling_m, highest).some((room_m) => room_m < 0),
  };
}

/** Scale of a chart that shows all lines of all legs alike, so that legs can be compared. */
export function scaleOf(
  legs: readonly ProfileLines[],
  shown: ProfileLines,
  size: Pick<Scale, "width_px" | "height_px">,
): Scale {
  const heights_m = legs
    .flatMap(({ lowestGround_m, ceiling_m, layers_m }) => [...lowestGround_m, ...ceiling_m, ...(layers_m.at(-1) ?? [])])
    .filter((height_m): height_m is number => height_m !== null);
  const bottom_m = Math.min(0, ...heights_m);
  const top_m = Math.max(1, ...heights_m);
  const margin_m = 0.04 * (top_m - bottom_m);
  return {
    ...size,
    length_m: Math.max(1, shown.distances_m.at(-1) ?? 1),
    bottom_m: bottom_m - margin_m,
    top_m: top_m + margin_m,
  };
}

/** SVG path of a line, with gaps where it is not known. */
export function linePath(distances_m: readonly number[], heights_m: Heights, scale: Scale): string {
  let isDown = false;
  const parts = distances_m.flatMap((distance_m, index) => {
    const height_m = heights_m[index] ?? null;
    const command = isDown ? "L" : "M";
    isDown = height_m !== null;
    return height_m === null ? [] : [`${command}${pointOf(distance_m, height_m, scale)}`];
  });
  return parts.join("");
}

/** SVG path of the area between two lines, of the stretches where both are known. */
export function bandPath(distances_m: readonly number[], low_m: Heights, high_m: Heights, scale: Scale): string {
  const stretches: [number, number, number][][] = [[]];
  distances_m.forEach((distance_m, index) => {
    const [low, high] = [low_m[index] ?? null, high_m[index] ?? null];
    if (low === null || high === null) stretches.push([]);
    else stretches.at(-1)?.push([distance_m, low, high]);
  });
  return stretches
    .filter((stretch) => stretch.length > 1)
    .map((stretch) => {
      const up = stretch.map(([distance_m, , high]) => pointOf(distance_m, high, scale));
      const back = stretch.toReversed().map(([distance_m, low]) => pointOf(distance_m, low, scale));
      return `M${[...up, ...back].join("L")}Z`;
    })
    .join("");
}

/** Round heights for the axis, about so many pixels apart. */
export function heightTicks({ bottom_m, top_m, height_px }: Scale, apart_px = 32): number[] {
  const wanted_m = ((top_m - bottom_m) * apart_px) / Math.max(1, height_px);
  const power = 10 ** Math.floor(Math.log10(wanted_m));
  const step_m = [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= wanted_m) ?? 10 * power;
  const first = Math.ceil(bottom_m / step_m);
  return Array.from({ length: Math.floor(top_m / step_m) - first + 1 }, (_, index) => (first + index) * step_m);
}

export const heightPx = (height_m: number, { bottom_m, top_m, height_px }: Scale): number =>
  height_px * (1 - (height_m - bottom_m) / (top_m - bottom_m));

function pointOf(distance_m: number, height_m: number, scale: Scale): string {
  const x = (scale.width_px * distance_m) / scale.length_m;
  return `${x.toFixed(1)},${heightPx(height_m, scale).toFixed(1)}`;
}

function difference(upper: Heights, lower: Heights): number[] {
  return upper.flatMap((height_m, index) => {
    const below_m = lower[index] ?? null;
    return height_m === null || below_m === null ? [] : [height_m - below_m];
  });
}
