/** Relief of the ground from the mission's elevation model: hill shading and contour lines. */
import type { ExpressionSpecification } from "maplibre-gl";
import type { Contours, Vertex } from "../../api/types";
import { quantity } from "../../format";
import { feature } from "../geojson";
import { featureLayer, type MapLayer } from "../layer";
import { cornersOf } from "./picture";

const SHADING = "shading";
const CONTOURS = "contours";
/** Every fifth line is a thick one with its height, and every fifth of those is drawn at all zooms. */
const INDEX_EVERY = 5;
/** Distance on the screen, in pixels, that neighbouring lines have in the mean at least; on slopes they are closer. */
const LEAST_SPACING_PX = 10;
/** Metres per pixel at the equator at zoom 0. */
const COARSEST_M_PER_PX = 78_271.517;
const OPACITY = 0.8;

/** Shading as a picture on the ground; null where its place is not known. */
export function shadingLayer(url: string, corners: readonly Vertex[]): MapLayer | null {
  const coordinates = cornersOf(corners);
  if (coordinates === null) return null;
  return {
    id: SHADING,
    attach(map) {
      map.addSource(SHADING, { type: "image", url, coordinates });
      map.addLayer({ id: SHADING, type: "raster", source: SHADING, paint: { "raster-fade-duration": 0 } });
      return {
        update: () => undefined, // the ground does not change
        remove() {
          map.removeLayer(SHADING);
          map.removeSource(SHADING);
        },
      };
    },
  };
}

/** Contour lines with their heights above sea level; the farther the map is zoomed out, the fewer of them. */
export function contoursLayer({ lines, interval_m, spacing_m }: Contours): MapLayer {
  const features = lines.map(({ altitude_amsl_m, latitude_deg, longitude_deg }) => {
    const coordinates = longitude_deg.map((lng, index) => [lng, latitude_deg[index] ?? NaN]);
    const rank = rankOf(Math.round(altitude_amsl_m / interval_m));
    return feature({ type: "LineString", coordinates }, { rank, height: quantity(altitude_amsl_m, 0, "m") });
  });
  const latitude_deg = lines[0]?.latitude_deg[0] ?? 0;
  const isIndex: ExpressionSpecification = [">=", ["get", "rank"], 1];
  const opacity: ExpressionSpecification = [
    "step",
    ["zoom"],
    opacityFrom(2),
    zoomOf(spacing_m * INDEX_EVERY, latitude_deg),
    opacityFrom(1),
    zoomOf(spacing_m, latitude_deg),
    OPACITY,
  ];
  return featureLayer({
    id: CONTOURS,
    paint: (palette) => [
      {
        type: "line",
        paint: {
          "line-color": palette.contour,
          "line-width": ["case", isIndex, 1.6, 0.8],
          "line-opacity": opacity,
        },
      },
      {
        type: "symbol",
        filter: isIndex,
        layout: { "symbol-placement": "line", "text-field": ["get", "height"], "text-size": 11 },
        paint: {
          "text-color": palette.contour,
          "text-halo-color": palette.halo,
          "text-halo-width": 1.5,
          "text-opacity": opacity,
        },
      },
    ],
    inputs: () => [features],
    features: () => features,
  });
}

/** Rank of a line by its number from the sea level: 0 for thin ones, 1 for thick ones, 2 for every fifth of those. */
function rankOf(number: number): number {
  if (number % INDEX_EVERY !== 0) return 0;
  return number % INDEX_EVERY ** 2 === 0 ? 2 : 1;
}

/** Opacity that hides lines of less than a rank. */
const opacityFrom = (rank: number): ExpressionSpecification => ["case", [">=", ["get", "rank"], rank], OPACITY, 0];

/** Zoom from which lines of a distance on the ground are far enough apart. */
const zoomOf = (spacing_m: number, latitude_deg: number): number =>
  Math.log2((LEAST_SPACING_PX * COARSEST_M_PER_PX * Math.cos((latitude_deg * Math.PI) / 180)) / spacing_m);
