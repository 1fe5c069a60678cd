/** Heights of the vehicles where there is room; prominent vehicles show theirs in their own layer. */
import { isStale } from "../../state/freshness";
import { enu, feature, point } from "../geojson";
import { featureLayer } from "../layer";
import { HEIGHT_LAYOUT, heightText, isProminent, labelInputs, labelPaint } from "./vehicles";

export const heightsLayer = featureLayer({
  id: "heights",
  interval_ms: 400,
  paint: (palette) => [{ type: "symbol", layout: HEIGHT_LAYOUT, paint: labelPaint(palette) }],
  inputs: labelInputs,
  features: (scene) =>
    scene.mission.vehicles.flatMap((vehicle) => {
      const { position } = vehicle;
      if (position === null || isProminent(vehicle, scene)) return [];
      const properties = { height: heightText(vehicle), isStale: isStale(vehicle, scene.snapshotAge_s) };
      return [feature(point(scene.origin, enu(position)), properties)];
    }),
});
