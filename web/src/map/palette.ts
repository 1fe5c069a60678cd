/** Colours of the map for every theme, since the canvas does not read CSS. */
import type { ExpressionSpecification } from "maplibre-gl";
import type { Theme } from "../theme";

export interface Palette {
  background: string;
  grid: string;
  gridMajor: string;
  area: string;
  contour: string;
  fence: string;
  home: string;
  refused: string;
  target: string;
  selected: string;
  label: string;
  /** Outline of labels and arrows. */
  halo: string;
  /** Colours of a vector base map. */
  ground: { earth: string; wood: string; water: string; building: string; road: string };
}

export const PALETTES: Readonly<Record<Theme, Palette>> = {
  dark: {
    background: "#10161b",
    grid: "#1a242c",
    gridMajor: "#293743",
    area: "#5fb0ff",
    contour: "#a08a66",
    fence: "#ff8f5a",
    home: "#c6d2dc",
    refused: "#ff5c5c",
    target: "#ff4fd0",
    selected: "#ffffff",
    label: "#ffffff",
    halo: "#05080a",
    ground: { earth: "#141b21", wood: "#15241c", water: "#12283a", building: "#27323b", road: "#3a4853" },
  },
  light: {
    background: "#f3f5f2",
    grid: "#e2e7e2",
    gridMajor: "#c7d0c9",
    area: "#0a5fb4",
    contour: "#8a6330",
    fence: "#b84400",
    home: "#33414c",
    refused: "#c40d1c",
    target: "#b4007f",
    selected: "#000000",
    label: "#0b141a",
    halo: "#ffffff",
    ground: { earth: "#f3f5f2", wood: "#dcebdc", water: "#c9e0f2", building: "#dcd8d2", road: "#c5bfb4" },
  },
  contrast: {
    background: "#ffffff",
    grid: "#e0e0e0",
    gridMajor: "#a8a8a8",
    area: "#00409a",
    contour: "#6b4410",
    fence: "#9c2f00",
    home: "#000000",
    refused: "#c00000",
    target: "#a00070",
    selected: "#000000",
    label: "#000000",
    halo: "#ffffff",
    ground: { earth: "#ffffff", wood: "#dff0df", water: "#c2dcf5", building: "#d0d0d0", road: "#8c8c8c" },
  },
};

/** Colours distinguishable with any colour vision (after Okabe and Ito), readable on all backgrounds. */
export const VEHICLE_COLOURS = [
  "#56b4e9",
  "#e69f00",
  "#1fb58f",
  "#d977b3",
  "#b9a800",
  "#4a8fdd",
  "#e0692a",
  "#9a8cf0",
] as const;

export function vehicleColour(vehicleId: number): string {
  return VEHICLE_COLOURS[(vehicleId - 1) % VEHICLE_COLOURS.length] ?? VEHICLE_COLOURS[0];
}

/** Expression that colours features by their property `id`. */
export function vehicleColourExpression(): ExpressionSpecification {
  const index = ["%", ["-", ["get", "id"], 1], VEHICLE_COLOURS.length];
  const cases = VEHICLE_COLOURS.flatMap((colour, i) => [i, colour]);
  return ["match", index, ...cases, VEHICLE_COLOURS[0]] as unknown as ExpressionSpecification;
}
