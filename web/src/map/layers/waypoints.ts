/** Current waypoints, and those that the safety monitor has shortened or held, with the reason. */
import type { Feature } from "geojson";
import type { Geodetic, Step, Vehicle } from "../../api/types";
import { said, texts } from "../../texts";
import { enu, feature, line, point } from "../geojson";
import { featureLayer } from "../layer";
import { vehicleColourExpression } from "../palette";

const isRole = (role: string): ["==", ["get", string], string] => ["==", ["get", "role"], role];

export const waypointsLayer = featureLayer({
  id: "waypoints",
  source: "swarm",
  interval_ms: 400,
  paint: (palette) => [
    {
      type: "line",
      filter: isRole("path"),
      paint: { "line-color": vehicleColourExpression(), "line-width": 1.5, "line-dasharray": [3, 3] },
    },
    {
      type: "circle",
      filter: isRole("sent"),
      paint: {
        "circle-radius": 4,
        "circle-opacity": 0,
        "circle-stroke-color": vehicleColourExpression(),
        "circle-stroke-width": 1.5,
      },
    },
    {
      type: "circle",
      filter: isRole("refused"),
      paint: {
        "circle-radius": 7,
        "circle-opacity": 0.15,
        "circle-color": palette.refused,
        "circle-stroke-color": palette.refused,
        "circle-stroke-width": 2,
      },
    },
    {
      type: "symbol",
      filter: isRole("refused"),
      layout: {
        "text-field": ["get", "reason"],
        "text-size": 11,
        "text-max-width": 14,
        "text-variable-anchor": ["top", "bottom", "left", "right"],
        "text-radial-offset": 0.9,
        "text-allow-overlap": true, // a reason matters more than a tidy map
      },
      paint: { "text-color": palette.refused, "text-halo-color": palette.halo, "text-halo-width": 1.5 },
    },
  ],
  inputs: ({ origin, mission, state }) => [
    origin.latitude_deg,
    origin.longitude_deg,
    mission.vehicles,
    state.latestStep,
  ],
  features: ({ origin, mission, state }) => [
    ...mission.vehicles.flatMap((vehicle) => pathFeatures(origin, vehicle)),
    ...refusedOf(state.latestStep).map(({ vehicle_id: id, requested, verdict, reason }) =>
      feature(point(origin, enu(requested)), {
        role: "refused",
        id,
        reason: `${texts.names.verdict[verdict]}: ${said(reason)}`,
      }),
    ),
  ],
});

function pathFeatures(origin: Geodetic, { vehicle_id: id, position, waypoint }: Vehicle): Feature[] {
  if (waypoint === null) return [];
  const place = feature(point(origin, enu(waypoint)), { role: "sent", id });
  if (position === null) return [place];
  return [place, feature(line(origin, [enu(position), enu(waypoint)]), { role: "path", id })];
}

/** Waypoints of a step that the safety monitor did not send as planned. */
function refusedOf(step: Step | null): Step["waypoints"] {
  return step?.waypoints.filter((waypoint) => waypoint.verdict !== "sent") ?? [];
}
