/** Tracked targets with their error ellipses of one standard deviation, and places that are left for a later look. */
import type { Feature } from "geojson";
import type { Geodetic, LeftPlace, Target } from "../../api/types";
import { ellipse } from "../../geometry";
import { likelihood } from "../../format";
import { texts } from "../../texts";
import { enu, feature, point, polygon } from "../geojson";
import { featureLayer } from "../layer";

export const targetsLayer = featureLayer({
  id: "targets",
  source: "swarm",
  paint: (palette) => [
    {
      type: "fill",
      filter: ["==", ["geometry-type"], "Polygon"],
      paint: { "fill-color": palette.target, "fill-opacity": 0.2, "fill-outline-color": palette.target },
    },
    {
      type: "circle",
      filter: ["==", ["geometry-type"], "Point"],
      paint: {
        "circle-radius": ["case", ["has", "isLater"], 5, 9],
        "circle-opacity": 0,
        "circle-stroke-color": palette.target,
        "circle-stroke-width": 2.5,
      },
    },
    {
      type: "symbol",
      filter: ["==", ["geometry-type"], "Point"],
      layout: {
        "text-field": ["get", "name"],
        "text-size": 12,
        "text-variable-anchor": ["left", "right", "top", "bottom"],
        "text-radial-offset": 1.1,
      },
      paint: { "text-color": palette.label, "text-halo-color": palette.halo, "text-halo-width": 2 },
    },
  ],
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.targets, mission.left_for_later])],
  features: ({ origin, mission }) => [
    ...mission.targets.flatMap((target) => featuresOf(origin, target)),
    ...mission.left_for_later.map((place) => laterPlace(origin, place)),
  ],
});

function featuresOf(origin: Geodetic, { track_id: id, position, ellipse: error }: Target): Feature[] {
  const place = feature(point(origin, enu(position)), { id, name: texts.map.target(id) });
  return error === null ? [place] : [feature(polygon(origin, ellipse(enu(position), error)), { id }), place];
}

function laterPlace(origin: Geodetic, { position, person_confidence: person }: LeftPlace): Feature {
  return feature(point(origin, enu(position)), { isLater: true, name: texts.map.later(likelihood(person)) });
}
