/** Launch points. */
import { enu, feature, point } from "../geojson";
import { featureLayer } from "../layer";

export const homesLayer = featureLayer({
  id: "homes",
  source: "ground",
  paint: (palette) => [
    {
      type: "circle",
      paint: {
        "circle-radius": 3,
        "circle-color": palette.home,
        "circle-stroke-color": palette.halo,
        "circle-stroke-width": 1,
      },
    },
  ],
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.vehicles.map((vehicle) => vehicle.home)])],
  features: ({ origin, mission }) =>
    mission.vehicles.flatMap(({ vehicle_id: id, home }) =>
      home === null ? [] : [feature(point(origin, enu(home)), { id })],
    ),
});
