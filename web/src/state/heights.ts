/** Heights of vehicles, with what they are counted from. */
import type { Vehicle } from "../api/types";
import { quantity } from "../format";
import { texts } from "../texts";

type Heights = Pick<Vehicle, "height_above_ground_m" | "height_above_home_m" | "altitude_amsl_m">;

const LOW_M = 10;

/** The height that matters most: above the ground where an elevation model tells it, otherwise above home. */
export function heightWords({ height_above_ground_m: ground_m, height_above_home_m: home_m }: Heights): string {
  if (ground_m !== null) return `${metres(ground_m)} ${texts.heights.agl}`;
  return home_m === null ? metres(null) : `${metres(home_m)} ${texts.heights.home}`;
}

/** Decimetres count near the ground, and take room above. */
const metres = (height_m: number | null): string =>
  quantity(height_m, height_m !== null && Math.abs(height_m) < LOW_M ? 1 : 0, "m");

/** All known heights in words, the most important first. */
export function allHeights(vehicle: Heights): string {
  const known: [number | null, string][] = [
    [vehicle.height_above_ground_m, texts.heights.aboveGround],
    [vehicle.height_above_home_m, texts.heights.aboveHome],
    [vehicle.altitude_amsl_m, texts.heights.aboveSea],
  ];
  return known
    .filter(([height_m]) => height_m !== null)
    .map(([height_m, words]) => `${quantity(height_m, 1, "m")} ${words}`)
    .join(", ");
}
