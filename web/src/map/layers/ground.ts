/** Style of a vector base map. Pure. */
import type { ExpressionSpecification, LayerSpecification } from "maplibre-gl";
import type { Palette } from "../palette";

/** Layer of the style, without its id and source. */
export type Part = WithoutPlace<Extract<LayerSpecification, { type: "fill" | "line" | "symbol" }>>;
type WithoutPlace<T> = T extends unknown ? Omit<T, "id" | "source"> : never;

/** Names of features in Protomaps and in OpenMapTiles, where they differ. */
const NAMES = {
  wood: ["landuse", "landcover"],
  streams: ["water", "waterway"],
  contours: ["contours", "contour"],
  buildings: ["buildings", "building"],
  roads: ["roads", "transportation"],
  places: ["places", "place"],
} as const;

const WOODED = ["wood", "forest", "scrub", "park", "nature_reserve", "national_park"];
/** Property called `kind` by Protomaps and `class` by OpenMapTiles. */
const KIND: ExpressionSpecification = ["coalesce", ["get", "kind"], ["get", "class"], ""];
const IS_WOODED: ExpressionSpecification = ["in", KIND, ["literal", WOODED]];
const NAME: ExpressionSpecification = ["get", "name"];
const HEIGHT: ExpressionSpecification = ["to-string", ["coalesce", ["get", "ele"], ["get", "height"], ""]];
const ROAD_WIDTH_PX: ExpressionSpecification = [
  "match",
  KIND,
  ["highway", "motorway", "trunk"],
  4,
  ["major_road", "medium_road", "primary", "secondary", "tertiary"],
  3,
  ["path", "track"],
  1,
  2,
];

/** Parts of the map, bottom up, in muted colours so that vehicles stand out. Layers that a map lacks draw nothing. */
export function groundParts({ ground, label, halo }: Palette): Part[] {
  const { wood, streams, contours, buildings, roads, places } = NAMES;
  const paint = { "text-color": label, "text-halo-color": halo, "text-halo-width": 1.5, "text-opacity": 0.8 };
  return [
    area("earth", ground.earth),
    ...wood.map((layer) => area(layer, ground.wood, IS_WOODED)),
    area("park", ground.wood),
    area("water", ground.water),
    ...streams.map((layer) => line(layer, ground.water, 1.5)),
    ...contours.map((layer) => line(layer, ground.road, 0.7)),
    ...buildings.map((layer) => area(layer, ground.building)),
    ...roads.map((layer) => line(layer, ground.road, ROAD_WIDTH_PX)),
    ...contours.map((layer): Part => {
      const layout = { "symbol-placement": "line", "text-field": HEIGHT, "text-size": 10 } as const;
      return { type: "symbol", "source-layer": layer, layout, paint };
    }),
    ...places.map((layer): Part => {
      const layout = { "text-field": NAME, "text-size": 12 };
      return { type: "symbol", "source-layer": layer, filter: isOf("Point"), layout, paint };
    }),
  ];
}

/** Map layers mix geometry types: the same one holds rivers as areas and as lines. */
const isOf = (shape: "Point" | "LineString" | "Polygon"): ExpressionSpecification => ["==", ["geometry-type"], shape];

function area(layer: string, colour: string, condition: ExpressionSpecification | true = true): Part {
  const filter: ExpressionSpecification = ["all", isOf("Polygon"), condition];
  return { type: "fill", "source-layer": layer, filter, paint: { "fill-color": colour } };
}

function line(layer: string, colour: string, width_px: number | ExpressionSpecification): Part {
  const paint = { "line-color": colour, "line-width": width_px };
  return { type: "line", "source-layer": layer, filter: isOf("LineString"), paint };
}
