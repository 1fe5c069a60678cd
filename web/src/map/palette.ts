/** Colours of the map; the two themes need their own because the canvas does not read CSS. */
export type Theme = "dark" | "light";

export interface Palette {
  background: string;
  grid: string;
  gridMajor: string;
  area: string;
  fence: string;
  home: string;
  waypoint: string;
  refused: string;
  target: string;
}

export const PALETTES: Readonly<Record<Theme, Palette>> = {
  dark: {
    background: "#10161b",
    grid: "#1a242c",
    gridMajor: "#293743",
    area: "#5fb0ff",
    fence: "#ff8f5a",
    home: "#c6d2dc",
    waypoint: "#e8eef3",
    refused: "#ff5c5c",
    target: "#ff4fd0",
  },
  light: {
    background: "#f3f5f2",
    grid: "#e2e7e2",
    gridMajor: "#c7d0c9",
    area: "#0a5fb4",
    fence: "#b84400",
    home: "#33414c",
    waypoint: "#22303a",
    refused: "#c40d1c",
    target: "#b4007f",
  },
};

/** Told apart by people with any colour vision (after Okabe and Ito), readable on both backgrounds. */
const VEHICLE_COLOURS = [
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

/** A MapLibre expression that colours features by their `id`. */
export function vehicleColourExpression(): ["match", ...unknown[]] {
  const index = ["%", ["-", ["get", "id"], 1], VEHICLE_COLOURS.length];
  return ["match", index, ...VEHICLE_COLOURS.flatMap((colour, i) => [i, colour]), VEHICLE_COLOURS[0]];
}
