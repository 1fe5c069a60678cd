/** Metric grid about the origin of the mission, to the edges of the map: the base map where there is no other. */
import type { Map as MapLibreMap } from "maplibre-gl";
import { type Bounds, boundsOf, gridLines, spacingOf, toEnu } from "../../geometry";
import type { Geodetic } from "../../api/types";
import { feature, line } from "../geojson";
import { type AttachedLayer, featureLayer, type MapLayer } from "../layer";
import type { Palette } from "../palette";

/** Share of the map's width and height that the grid reaches beyond each edge, so that most movements need no other. */
const BEYOND = 0.6;
/** Lines across the map, about, without what is beyond its edges. */
const LINES = 40;

/** Width of the map from which there is no grid. */
const WIDEST_M = 100_000;

/** Part of the ground that the grid covers. */
interface Covered {
  /** Null where the map shows so much that metres about the origin mean nothing. */
  readonly bounds: Bounds | null;
  readonly spacing_m: number;
}

const NOWHERE: Covered = { bounds: null, spacing_m: 0 };

/** Grid that is the base map, and one above a base map. */
export const gridLayer = gridOf(1);
export const faintGridLayer = gridOf(0.35);

function gridOf(opacity: number): MapLayer {
  return { id: "grid", attach: (map, palette) => attachGrid(map, palette, opacity) };
}

function attachGrid(map: MapLibreMap, palette: Palette, opacity: number): AttachedLayer {
  let covered: Covered | null = null;
  const lines = featureLayer({
    id: "grid",
    source: "ground",
    paint: () => [
      {
        type: "line",
        filter: ["!", ["get", "isMajor"]],
        paint: { "line-color": palette.grid, "line-width": 1, "line-opacity": opacity },
      },
      {
        type: "line",
        filter: ["get", "isMajor"],
        paint: { "line-color": palette.gridMajor, "line-width": 1, "line-opacity": opacity },
      },
    ],
    inputs: ({ origin }) => [origin.latitude_deg, origin.longitude_deg, covered],
    features: ({ origin }) =>
      !covered?.bounds
        ? []
        : gridLines(covered.bounds, covered.spacing_m).map(({ from, to, isMajor }) =>
            feature(line(origin, [from, to]), { isMajor }),
          ),
  }).attach(map, palette);
  let shown: Parameters<AttachedLayer["update"]>[0] | null = null;
  const draw = (): void => {
    if (shown === null) return;
    covered = coverage(seen(map, shown.origin), covered);
    lines.update(shown);
  };
  const moved = map.on("move", draw);
  const resized = map.on("resize", draw);
  return {
    update(scene) {
      shown = scene;
      draw();
    },
    remove() {
      moved.unsubscribe();
      resized.unsubscribe();
      lines.remove();
    },
  };
}

/** Part of the ground that the grid has to cover: the same as before while that does. */
function coverage(view: Bounds, before: Covered | null): Covered {
  const [width_m, height_m] = [view.east_m - view.west_m, view.north_m - view.south_m];
  if (Math.max(width_m, height_m) > WIDEST_M) return before?.bounds === null ? before : NOWHERE;
  const spacing_m = spacingOf(Math.max(width_m, height_m) / LINES);
  if (before?.bounds && before.spacing_m === spacing_m && contains(before.bounds, view)) return before;
  return {
    bounds: {
      west_m: view.west_m - BEYOND * width_m,
      south_m: view.south_m - BEYOND * height_m,
      east_m: view.east_m + BEYOND * width_m,
      north_m: view.north_m + BEYOND * height_m,
    },
    spacing_m,
  };
}

const contains = (outer: Bounds, inner: Bounds): boolean =>
  outer.west_m <= inner.west_m &&
  outer.south_m <= inner.south_m &&
  outer.east_m >= inner.east_m &&
  outer.north_m >= inner.north_m;

/** Part of the ground that the map shows. */
function seen(map: MapLibreMap, origin: Geodetic): Bounds {
  const bounds = map.getBounds();
  const corners = [bounds.getSouthWest(), bounds.getNorthEast()].map(({ lng, lat }) => toEnu(origin, [lng, lat]));
  return boundsOf(corners) ?? { west_m: 0, south_m: 0, east_m: 0, north_m: 0 };
}
