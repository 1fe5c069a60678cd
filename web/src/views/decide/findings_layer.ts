/** Map layers: findings with their error ellipses of one standard deviation, and the pointer that marks new ones. */
import type { Feature } from "geojson";
import type { Finding, Geodetic, Place } from "../../api/types";
import { ellipse } from "../../geometry";
import { enu, feature, point, polygon } from "../../map/geojson";
import { featureLayer, type MapLayer } from "../../map/layer";
import { texts } from "../../texts";
import { counting, STATUS_SIGNS } from "./findings";

/** Make the layer, once: `chosen` is read at every update. */
export function findingsLayer(chosen: () => number | null, onChoose: (id: number) => void): MapLayer {
  return featureLayer({
    id: "findings",
    paint: (palette) => [
      {
        type: "fill",
        filter: ["==", ["geometry-type"], "Polygon"],
        paint: { "fill-color": palette.target, "fill-opacity": 0.2, "fill-outline-color": palette.target },
      },
      {
        type: "circle",
        filter: ["==", ["geometry-type"], "Point"],
        paint: {
          "circle-radius": ["case", ["get", "isChosen"], 14, 9],
          "circle-color": palette.background,
          "circle-opacity": 0.35,
          "circle-stroke-color": ["case", ["get", "isChosen"], palette.selected, palette.target],
          "circle-stroke-width": ["case", ["get", "isChosen"], 4, 2.5],
        },
      },
      {
        type: "symbol",
        filter: ["==", ["geometry-type"], "Point"],
        layout: {
          "text-field": ["get", "name"],
          "text-size": 13,
          "text-variable-anchor": ["left", "right", "top", "bottom"],
          "text-radial-offset": 1.2,
        },
        paint: { "text-color": palette.label, "text-halo-color": palette.halo, "text-halo-width": 1.5 },
      },
    ],
    inputs: ({ origin, mission }) => [JSON.stringify([origin, mission.findings]), chosen()],
    features: ({ origin, mission }) => counting(mission.findings).flatMap((one) => featuresOf(origin, one, chosen())),
    onClick: onChoose,
  });
}

function featuresOf(origin: Geodetic, finding: Finding, chosen: number | null): Feature[] {
  const { finding_id: id, position, ellipse: error, status } = finding;
  const name = `${texts.decide.finding(id)} ${STATUS_SIGNS[status]}`;
  const place = feature(point(origin, enu(position)), { id, name, isChosen: id === chosen });
  return error === null ? [place] : [feature(polygon(origin, ellipse(enu(position), error)), { id }), place];
}

/** Reports clicks on the map while a position is being marked; draws nothing. */
export function markLayer(isMarking: () => boolean, onPlace: (place: Place) => void): MapLayer {
  return {
    id: "mark",
    attach(map) {
      const clicks = map.on("click", ({ lngLat: { lng, lat } }) => {
        if (isMarking()) onPlace({ latitude_deg: lat, longitude_deg: lng });
      });
      return {
        update: () => {
          map.getCanvas().style.cursor = isMarking() ? "crosshair" : "";
        },
        remove: () => clicks.unsubscribe(),
      };
    },
  };
}
