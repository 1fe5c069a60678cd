/** Legs of the scan as the path of the centre of the line; the current leg is highlighted. */
import { enu, feature, line } from "../geojson";
import { featureLayer } from "../layer";

export const legsLayer = featureLayer({
  id: "legs",
  source: "ground",
  paint: (palette) => [
    {
      type: "line",
      paint: {
        "line-color": palette.area,
        "line-width": ["case", ["get", "isFlown"], 2.5, 1],
        "line-opacity": 0.7,
      },
    },
  ],
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.legs, mission.leg])],
  features: ({ origin, mission }) =>
    mission.legs.map(({ start, end }, index) =>
      feature(line(origin, [enu(start), enu(end)]), { isFlown: index === mission.leg }),
    ),
});
