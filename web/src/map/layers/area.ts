/** Search area, geofence and no-go zones. */
import { enu, feature, polygon } from "../geojson";
import { featureLayer } from "../layer";

export const areaLayer = featureLayer({
  id: "area",
  source: "ground",
  paint: (palette) => [
    {
      type: "fill",
      filter: ["==", ["get", "role"], "no-go"],
      paint: { "fill-color": palette.fence, "fill-opacity": 0.2, "fill-outline-color": palette.fence },
    },
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
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.area, mission.fence, mission.no_go])],
  features: ({ origin, mission }) =>
    [
      { role: "area", corners: mission.area.map(enu) },
      { role: "fence", corners: mission.fence.map(enu) },
      ...mission.no_go.map((zone) => ({ role: "no-go", corners: zone.map(enu) })),
    ]
      .filter(({ corners }) => corners.length > 2)
      .map(({ role, corners }) => feature(polygon(origin, corners), { role })),
});
