/** Marks and drawings of others that wait for a decision: dashed, so that nobody takes them for the plan. */
import type { Feature, Geometry } from "geojson";
import type { Proposal } from "../../api/types";
import { lngLat } from "../../geometry";
import { waiting } from "../../state/proposals";
import { feature } from "../geojson";
import { featureLayer } from "../layer";

export const proposalsLayer = featureLayer({
  id: "proposals",
  paint: (palette) => [
    {
      type: "line",
      filter: ["!=", ["geometry-type"], "Point"],
      paint: { "line-color": palette.home, "line-width": 2, "line-dasharray": [1, 2] },
    },
    {
      type: "circle",
      filter: ["==", ["geometry-type"], "Point"],
      paint: {
        "circle-radius": 6,
        "circle-color": palette.background,
        "circle-stroke-color": palette.home,
        "circle-stroke-width": 2,
      },
    },
    {
      type: "symbol",
      layout: {
        "text-field": ["get", "name"],
        "text-size": 12,
        "text-variable-anchor": ["left", "right", "top", "bottom"],
        "text-radial-offset": 1,
      },
      paint: { "text-color": palette.label, "text-halo-color": palette.halo, "text-halo-width": 1.5 },
    },
  ],
  inputs: ({ mission }) => [JSON.stringify(waiting(mission.proposals).map(({ proposal_id }) => proposal_id))],
  features: ({ mission }) => waiting(mission.proposals).map(featureOf),
});

export function featureOf({ name, shape, places }: Pick<Proposal, "name" | "shape" | "places">): Feature {
  const points = places.map(lngLat);
  const geometries: Record<Proposal["shape"], Geometry> = {
    point: { type: "Point", coordinates: points[0] ?? [] },
    line: { type: "LineString", coordinates: points },
    area: { type: "Polygon", coordinates: [[...points, ...points.slice(0, 1)]] },
  };
  return feature(geometries[shape], { name });
}
