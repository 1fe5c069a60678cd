/** Arrows of the vehicles as images of the map, one per colour and outline. */
import type { Map as MapLibreMap } from "maplibre-gl";
import { type Palette, VEHICLE_COLOURS, vehicleColour } from "./palette";

const SIZE_PX = 34;
/** Drawn at a higher resolution, for screens with more than one device pixel per pixel. */
const PIXEL_RATIO = 2;
const OUTLINE: readonly (readonly [number, number])[] = [
  [0.5, 0.08],
  [0.82, 0.86],
  [0.5, 0.68],
  [0.18, 0.86],
];

/** Name of a vehicle's arrow; a refused waypoint gives it a red outline. */
export function arrowName(vehicleId: number, isRefused: boolean): string {
  return `arrow-${vehicleColour(vehicleId)}${isRefused ? "-refused" : ""}`;
}

export function addArrows(map: MapLibreMap, palette: Palette): void {
  VEHICLE_COLOURS.forEach((colour, index) => {
    for (const isRefused of [false, true]) {
      const name = arrowName(index + 1, isRefused);
      if (map.hasImage(name)) map.removeImage(name);
      map.addImage(name, draw(colour, isRefused ? palette.refused : palette.halo, isRefused ? 3 : 1.5), {
        pixelRatio: PIXEL_RATIO,
      });
    }
  });
}

function draw(colour: string, outline: string, outlineWidth_px: number): ImageData {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIZE_PX * PIXEL_RATIO;
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("the browser has no canvas");
  context.beginPath();
  for (const [x, y] of OUTLINE) context.lineTo(x * canvas.width, y * canvas.height);
  context.closePath();
  context.lineJoin = "round";
  context.lineWidth = 2 * outlineWidth_px * PIXEL_RATIO;
  context.strokeStyle = outline;
  context.stroke();
  context.fillStyle = colour;
  context.fill();
  return context.getImageData(0, 0, canvas.width, canvas.height);
}
