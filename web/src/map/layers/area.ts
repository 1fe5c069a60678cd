/** Where is searched, and what no vehicle may leave. */
import { enu, feature, polygon } from "../geojson";
import { featureLayer } from "../layer";

export const areaLayer = featureLayer({
  id: "area",
  paint: (palette) => [
    {
      type: "fill",
      filter: ["==", ["get", "role"], "area"],
      paint: { "fill-color": palette.area, "fill-opacity": 0.05 },
    },
    {
      type: "line",
      filter: ["==", ["get", "role"], "area"],
      paint: { "line-color": palette.area, "line-width": 1.5 },
    },
    {
      type: "line",
      filter: ["==", ["get", "role"], "fence"],
      paint: { "line-color": palette.fence, "line-width": 2, "line-dasharray": [4, 2] },
    },
  ],
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.area, mission.fence])],
  features: ({ origin, mission }) =>
    [
      { role: "area", corners: mission.area.map(enu) },
      { role: "fence", corners: mission.fence.map(enu) },
    ]
      .filter(({ corners }) => corners.length > 2)
      .map(({ role, corners }) => feature(polygon(origin, corners), { role })),
});
