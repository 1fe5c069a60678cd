/** Metric grid about the origin of the mission, which serves as the base map where there is no other. */
import { boundsOf, type GridLine, gridLines } from "../../geometry";
import type { Mission } from "../../api/types";
import { enu, feature, line } from "../geojson";
import { featureLayer } from "../layer";

const MARGIN_M = 400;
const SPACING_M = 10;
const MAX_LINES = 240;
const FINE_FROM_ZOOM = 15;

export const gridLayer = featureLayer({
  id: "grid",
  source: "ground",
  paint: (palette) => [
    {
      type: "line",
      filter: ["!", ["get", "isMajor"]],
      minzoom: FINE_FROM_ZOOM,
      paint: { "line-color": palette.grid, "line-width": 1 },
    },
    { type: "line", filter: ["get", "isMajor"], paint: { "line-color": palette.gridMajor, "line-width": 1 } },
  ],
  inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.area, mission.fence])],
  features: ({ origin, mission }) =>
    lines(mission).map(({ from, to, isMajor }) => feature(line(origin, [from, to]), { isMajor })),
});

function lines(mission: Mission): GridLine[] {
  const bounds = boundsOf([...mission.area.map(enu), ...mission.fence.map(enu), [0, 0]], MARGIN_M);
  if (bounds === null) return [];
  let spacing_m = SPACING_M;
  while ((2 * (bounds.east_m - bounds.west_m)) / spacing_m > MAX_LINES) spacing_m *= 2;
  return gridLines(bounds, spacing_m);
}
