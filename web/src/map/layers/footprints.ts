/** Footprints of the latest frames on the focal plane. */
import { enu, feature, polygon } from "../geojson";
import { featureLayer } from "../layer";
import { vehicleColourExpression } from "../palette";

export const footprintsLayer = featureLayer({
  id: "footprints",
  source: "swarm",
  interval_ms: 400,
  paint: () => [
    { type: "fill", paint: { "fill-color": vehicleColourExpression(), "fill-opacity": 0.06 } },
    { type: "line", paint: { "line-color": vehicleColourExpression(), "line-width": 1, "line-opacity": 0.7 } },
  ],
  inputs: ({ origin, mission }) => [
    origin.latitude_deg,
    origin.longitude_deg,
    ...mission.vehicles.map((vehicle) => vehicle.camera?.footprint),
  ],
  features: ({ origin, mission }) =>
    mission.vehicles.flatMap(({ vehicle_id: id, camera }) =>
      camera === null || camera.footprint.length < 3
        ? []
        : [feature(polygon(origin, camera.footprint.map(enu)), { id })],
    ),
});
