/** The map's style: a background and our own GeoJSON; nothing is loaded from a network. */
import type { LayerSpecification, SourceSpecification, StyleSpecification } from "maplibre-gl";
import { PALETTES, type Theme, vehicleColourExpression } from "./palette";
import type { Role } from "./features";

export const FIXED_SOURCE = "fixed";
export const MOVING_SOURCE = "moving";
/** The picture is put below this layer. */
export const ABOVE_PICTURE = "area-fill";

const EMPTY: SourceSpecification = { type: "geojson", data: { type: "FeatureCollection", features: [] } };
const is = (role: Role): ["==", ...unknown[]] => ["==", ["get", "role"], role];

/** The style of a theme, with empty sources. */
export function makeStyle(theme: Theme): StyleSpecification {
  const colours = PALETTES[theme];
  const vehicle = vehicleColourExpression();
  const layers = [
    { id: "background", type: "background", paint: { "background-color": colours.background } },
    lineLayer("grid", FIXED_SOURCE, "grid", { "line-color": colours.grid, "line-width": 1 }, 15),
    lineLayer("grid-major", FIXED_SOURCE, "grid-major", { "line-color": colours.gridMajor, "line-width": 1 }),
    {
      id: ABOVE_PICTURE,
      type: "fill",
      source: FIXED_SOURCE,
      filter: is("area"),
      paint: { "fill-color": colours.area, "fill-opacity": 0.05 },
    },
    lineLayer("area", FIXED_SOURCE, "area", { "line-color": colours.area, "line-width": 1.5 }),
    lineLayer("fence", FIXED_SOURCE, "fence", {
      "line-color": colours.fence,
      "line-width": 2,
      "line-dasharray": [4, 2],
    }),
    circleLayer("home", FIXED_SOURCE, { "circle-radius": 3, "circle-color": colours.home, "circle-opacity": 0.8 }),
    lineLayer("trail", MOVING_SOURCE, "trail", { "line-color": vehicle, "line-width": 2, "line-opacity": 0.6 }),
    lineLayer("plan", MOVING_SOURCE, "plan", { "line-color": vehicle, "line-width": 1, "line-dasharray": [3, 3] }),
    circleLayer("waypoint", MOVING_SOURCE, {
      "circle-radius": 4,
      "circle-opacity": 0,
      "circle-stroke-color": vehicle,
      "circle-stroke-width": 1.5,
    }),
    circleLayer("refused", MOVING_SOURCE, {
      "circle-radius": 6,
      "circle-opacity": 0.15,
      "circle-color": colours.refused,
      "circle-stroke-color": colours.refused,
      "circle-stroke-width": 2,
    }),
    {
      id: "sigma",
      type: "fill",
      source: MOVING_SOURCE,
      filter: is("sigma"),
      paint: { "fill-color": colours.target, "fill-opacity": 0.2, "fill-outline-color": colours.target },
    },
  ];
  return {
    version: 8,
    sources: { [FIXED_SOURCE]: EMPTY, [MOVING_SOURCE]: EMPTY },
    layers: layers as LayerSpecification[],
  };
}

function lineLayer(id: string, source: string, role: Role, paint: object, minzoom = 0): object {
  return { id, type: "line", source, filter: is(role), paint, minzoom };
}

function circleLayer(role: Role, source: string, paint: object): object {
  return { id: role, type: "circle", source, filter: is(role), paint };
}
