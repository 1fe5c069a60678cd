/** Relief of the ground from the mission's elevation model: hill shading and contour lines. */
import type { Contours, Vertex } from "../../api/types";
import { quantity } from "../../format";
import { feature } from "../geojson";
import { featureLayer, type MapLayer } from "../layer";
import { cornersOf } from "./picture";

const SHADING = "shading";
const CONTOURS = "contours";
/** Every fifth line is a thick one with its height. */
const INDEX_EVERY = 5;

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

/** Contour lines with their heights above sea level. */
export function contoursLayer({ lines, interval_m }: Contours): MapLayer {
  const features = lines.map(({ altitude_amsl_m, latitude_deg, longitude_deg }) => {
    const coordinates = longitude_deg.map((lng, index) => [lng, latitude_deg[index] ?? NaN]);
    const isIndex = Math.round(altitude_amsl_m / interval_m) % INDEX_EVERY === 0;
    return feature({ type: "LineString", coordinates }, { isIndex, height: quantity(altitude_amsl_m, 0, "m") });
  });
  return featureLayer({
    id: CONTOURS,
    paint: (palette) => [
      {
        type: "line",
        paint: {
          "line-color": palette.contour,
          "line-width": ["case", ["get", "isIndex"], 1.6, 0.8],
          "line-opacity": 0.8,
        },
      },
      {
        type: "symbol",
        filter: ["get", "isIndex"],
        layout: { "symbol-placement": "line", "text-field": ["get", "height"], "text-size": 11 },
        paint: { "text-color": palette.contour, "text-halo-color": palette.halo, "text-halo-width": 1.5 },
      },
    ],
    inputs: () => [features],
    features: () => features,
  });
}
