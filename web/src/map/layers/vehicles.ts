/** Vehicles as numbered arrows in the direction of their headings; their heights stand beside them where there is room. */
import { quantity } from "../../format";
import { isStale } from "../../state/freshness";
import { addArrows, arrowName } from "../arrows";
import { enu, feature, point } from "../geojson";
import { featureLayer, type MapLayer } from "../layer";

/** A part of a second more or less changes nothing that is shown. */
const AGE_STEP_S = 0.5;

/** `onClick` gets the vehicle's number and the event with its modifiers. */
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
      // Below the arrows, because what lies above is placed first: heights keep clear of all arrows.
      {
        type: "symbol",
        layout: {
          "text-field": ["get", "height"],
          "text-size": 11,
          "text-variable-anchor": ["left", "right", "top", "bottom", "top-left", "top-right", "bottom-left"],
          "text-radial-offset": 1.9,
          "text-justify": "auto",
        },
        paint: {
          "text-color": palette.label,
          "text-opacity": ["case", ["get", "isStale"], 0.6, 1],
          "text-halo-color": palette.halo,
          "text-halo-width": 1.5,
        },
      },
      {
        type: "symbol",
        layout: {
          "icon-image": ["get", "arrow"],
          "icon-rotate": ["get", "heading_deg"],
          "icon-rotation-alignment": "map",
          "icon-allow-overlap": true,
          "icon-padding": 0,
          "text-field": ["to-string", ["get", "id"]],
          "text-size": 12,
          "text-offset": [0, 0.1],
          "text-allow-overlap": true,
        },
        paint: {
          "icon-opacity": ["case", ["get", "isStale"], 0.4, 1],
          "text-color": palette.label,
          "text-halo-color": palette.halo,
          "text-halo-width": 1.5,
        },
      },
    ],
    inputs: ({ origin, mission, selected, snapshotAge_s }) => [
      origin.latitude_deg,
      origin.longitude_deg,
      mission.vehicles,
      selected,
      Math.floor(snapshotAge_s / AGE_STEP_S),
    ],
    features: ({ origin, mission, selected, snapshotAge_s }) =>
      mission.vehicles.flatMap((vehicle) => {
        const { vehicle_id: id, position } = vehicle;
        if (position === null) return [];
        const properties = {
          id,
          arrow: arrowName(id, vehicle.refusal !== null),
          heading_deg: vehicle.heading_deg ?? 0,
          height: quantity(vehicle.height_above_home_m, 0, "m"),
          isSelected: selected.has(id),
          isStale: isStale(vehicle, snapshotAge_s),
        };
        return [feature(point(origin, enu(position)), properties)];
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
