/**
 * Vehicles as arrows in the direction of their headings, with their numbers.
 *
 * Where vehicles are close together some labels are left out, but never those of vehicles that are selected or need
 * attention, which lie on top and include the heights. The heights of all other vehicles are a layer of their own.
 */
import type { ExpressionSpecification } from "maplibre-gl";
import type { Vehicle } from "../../api/types";
import { heightWords } from "../../state/heights";
import { isStale } from "../../state/freshness";
import { addArrows, arrowName } from "../arrows";
import { enu, feature, point } from "../geojson";
import { featureLayer, type MapLayer, type Scene } from "../layer";
import type { Palette } from "../palette";

/** Interval of updates; changes within a fraction of a second are not visible. */
const AGE_STEP_S = 0.5;

const IS_PROMINENT: ExpressionSpecification = ["get", "isProminent"];

/** Style of labels; those of outdated values are paler. */
export const labelPaint = (palette: Palette) => ({
  "text-color": palette.label,
  "text-opacity": ["case", ["get", "isStale"], 0.6, 1] as ExpressionSpecification,
  "text-halo-color": palette.halo,
  "text-halo-width": 1.5,
});

/** Position of a height beside its arrow, on the side that is free. */
export const HEIGHT_LAYOUT = {
  "text-field": ["get", "height"] as ExpressionSpecification,
  "text-size": 11,
  "text-variable-anchor": ["left", "right", "top", "bottom"] as ("left" | "right" | "top" | "bottom")[],
  "text-radial-offset": 1.9,
  "text-justify": "auto" as const,
};

/** Whether a vehicle's label must always be readable: it is selected, refused, or has no contact on its own. */
export function isProminent(vehicle: Vehicle, { selected }: Scene): boolean {
  return selected.has(vehicle.vehicle_id) || vehicle.refusal !== null || isStale(vehicle, 0);
}

/** Height with the vehicle's number, because a neighbour may be as near; empty on the ground. */
export function heightText(vehicle: Vehicle): string {
  return vehicle.landed === "on_ground" ? "" : `${vehicle.vehicle_id}: ${heightWords(vehicle)}`;
}

/** Values that vehicle labels depend on. */
export const labelInputs = ({ origin, mission, selected, snapshotAge_s }: Scene): unknown[] => [
  origin.latitude_deg,
  origin.longitude_deg,
  mission.vehicles,
  selected,
  Math.floor(snapshotAge_s / AGE_STEP_S),
];

/** `onClick` receives the number of the vehicle and the event with its modifiers. */
export function vehiclesLayer(onClick: (vehicleId: number, event: MouseEvent) => void): MapLayer {
  const layer = featureLayer({
    id: "vehicles",
    paint: (palette) => [
      {
        type: "circle",
        filter: ["get", "isSelected"],
        paint: {
          "circle-radius": 17,
          "circle-color": palette.selected,
          "circle-opacity": 0.15,
          "circle-stroke-color": palette.selected,
          "circle-stroke-width": 2,
        },
      },
      {
        type: "symbol",
        layout: {
          "icon-image": ["get", "arrow"],
          "icon-size": ["interpolate", ["linear"], ["zoom"], 16, 0.7, 19, 1],
          "icon-rotate": ["get", "heading_deg"],
          "icon-rotation-alignment": "map",
          "icon-allow-overlap": true,
          "icon-ignore-placement": true,
          "symbol-sort-key": ["to-number", IS_PROMINENT],
        },
        paint: { "icon-opacity": ["case", ["get", "isStale"], 0.4, 1] },
      },
      {
        type: "symbol",
        filter: ["!", IS_PROMINENT],
        layout: {
          "text-field": ["to-string", ["get", "id"]],
          "text-size": 12,
          "text-padding": 0,
          "text-variable-anchor": ["center", "top", "bottom"],
          "text-radial-offset": 0.6,
        },
        paint: labelPaint(palette),
      },
      { type: "symbol", filter: IS_PROMINENT, layout: HEIGHT_LAYOUT, paint: labelPaint(palette) },
      {
        type: "symbol",
        filter: IS_PROMINENT,
        layout: { "text-field": ["to-string", ["get", "id"]], "text-size": 13, "text-allow-overlap": true },
        paint: labelPaint(palette),
      },
    ],
    inputs: labelInputs,
    features: (scene) =>
      scene.mission.vehicles.flatMap((vehicle) => {
        const { vehicle_id: id, position } = vehicle;
        if (position === null) return [];
        const properties = {
          id,
          arrow: arrowName(id, vehicle.refusal !== null),
          heading_deg: vehicle.heading_deg ?? 0,
          height: heightText(vehicle),
          isProminent: isProminent(vehicle, scene),
          isSelected: scene.selected.has(id),
          isStale: isStale(vehicle, scene.snapshotAge_s),
        };
        return [feature(point(scene.origin, enu(position)), properties)];
      }),
    onClick,
  });
  return {
    ...layer,
    attach(map, palette) {
      addArrows(map, palette);
      return layer.attach(map, palette);
    },
  };
}
