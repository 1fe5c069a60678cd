/** Part of the ground that an image view shows, north up. Pure functions; pixels are those of the page, y down. */
import type { Bounds } from "../../geometry";
import type { EnuPoint } from "../../state/state";
import type { Size } from "../../ui/use_size";

export interface Viewport {
  readonly centre: EnuPoint;
  readonly metresPerPx: number;
}

export type ScreenPoint = readonly [x_px: number, y_px: number];

const FINEST_M_PER_PX = 0.002;
const COARSEST_M_PER_PX = 20;
/** Margin around fitted bounds, as a factor. */
const FIT_MARGIN = 1.06;

export function toScreen({ centre, metresPerPx }: Viewport, size: Size, [east_m, north_m]: EnuPoint): ScreenPoint {
  return [
    size.width_px / 2 + (east_m - centre[0]) / metresPerPx,
    size.height_px / 2 - (north_m - centre[1]) / metresPerPx,
  ];
}

/** The inverse of {@link toScreen}. */
export function toGround({ centre, metresPerPx }: Viewport, size: Size, [x_px, y_px]: ScreenPoint): EnuPoint {
  return [centre[0] + (x_px - size.width_px / 2) * metresPerPx, centre[1] - (y_px - size.height_px / 2) * metresPerPx];
}

/** Viewport that shows all of the bounds. */
export function fitted(bounds: Bounds, size: Size): Viewport {
  const [width_m, height_m] = [bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m];
  const scale = Math.max(width_m / Math.max(1, size.width_px), height_m / Math.max(1, size.height_px));
  return {
    centre: [(bounds.west_m + bounds.east_m) / 2, (bounds.south_m + bounds.north_m) / 2],
    metresPerPx: clampScale(scale * FIT_MARGIN),
  };
}

/** Viewport moved by pixels, as a finger drags the image. */
export function panned({ centre, metresPerPx }: Viewport, [dx_px, dy_px]: ScreenPoint): Viewport {
  return { centre: [centre[0] - dx_px * metresPerPx, centre[1] + dy_px * metresPerPx], metresPerPx };
}

/** Viewport scaled by a factor; the ground at the given point of the screen stays there. */
export function zoomed(viewport: Viewport, size: Size, factor: number, at: ScreenPoint): Viewport {
  const metresPerPx = clampScale(viewport.metresPerPx / factor);
  const [east_m, north_m] = toGround(viewport, size, at);
  const [dx_px, dy_px] = [at[0] - size.width_px / 2, at[1] - size.height_px / 2];
  return { centre: [east_m - dx_px * metresPerPx, north_m + dy_px * metresPerPx], metresPerPx };
}

const clampScale = (metresPerPx: number): number => Math.min(COARSEST_M_PER_PX, Math.max(FINEST_M_PER_PX, metresPerPx));

/** Longest bar of 1, 2 or 5 times a power of ten metres that is not wider than the given width. */
export function scaleBar(metresPerPx: number, widest_px: number): { length_m: number; width_px: number } {
  const longest_m = metresPerPx * widest_px;
  const power = 10 ** Math.floor(Math.log10(longest_m));
  const length_m = power * ([5, 2].find((factor) => factor * power <= longest_m) ?? 1);
  return { length_m, width_px: length_m / metresPerPx };
}

/** Lengths of the segments of a line on the ground. */
export function pieces_m(points: readonly EnuPoint[]): number[] {
  return points.slice(1).map(([east_m, north_m], index) => {
    const from = points[index] as EnuPoint;
    return Math.hypot(east_m - from[0], north_m - from[1]);
  });
}
