/** Recent paths of the vehicles. */
import { feature, line } from "../geojson";
import { featureLayer } from "../layer";
import { vehicleColourExpression } from "../palette";

export const trailsLayer = featureLayer({
  id: "trails",
  interval_ms: 1000,
  paint: () => [
    { type: "line", paint: { "line-color": vehicleColourExpression(), "line-width": 2, "line-opacity": 0.6 } },
  ],
  inputs: ({ origin, state }) => [origin.latitude_deg, origin.longitude_deg, state.trails],
  features: ({ origin, state }) =>
    [...state.trails].flatMap(([id, trail]) => (trail.length > 1 ? [feature(line(origin, trail), { id })] : [])),
});
