/** Values as text. A value that was never reported is a dash, not a zero. */
import { texts } from "./texts";
import { shownUnit } from "./units";

export const UNKNOWN = "–";

/** Number of a quantity alone, where its unit stands elsewhere; in the unit that {@link quantity} shows. */
export const amount = (value: number, decimals: number, unit: string): string =>
  quantity(value * shownUnit(unit).factor, decimals);

/** Number with fixed decimals and its unit; lengths, areas and speeds are given in metric units and shown in the chosen. */
export function quantity(value: number | null | undefined, decimals: number, unit = ""): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return UNKNOWN;
  const shown = shownUnit(unit);
  const rounded = (value * shown.factor).toFixed(decimals);
  const number = rounded.replace("-", Number(rounded) === 0 ? "" : "\u2212");
  return unit === "" ? number : `${number}\u202f${shown.unit}`;
}

/** Probability in percent. */
export const likelihood = (probability: number | null): string =>
  probability === null ? texts.noData : quantity(100 * probability, 0, "%");

/** Minutes and seconds, with hours where needed. */
export function duration(seconds: number): string {
  const total = Math.max(0, Math.floor(seconds));
  const [h, m, s] = [Math.floor(total / 3600), Math.floor(total / 60) % 60, total % 60];
  const two = (n: number): string => String(n).padStart(2, "0");
  return h > 0 ? `${h}:${two(m)}:${two(s)}` : `${two(m)}:${two(s)}`;
}

/** Time of day at this screen, with its time zone. */
export function timeOfDay(utc_s: number): string {
  return new Date(1000 * utc_s).toLocaleTimeString([], { hourCycle: "h23", timeZoneName: "short" });
}

/** Distance on the ground: metres, or kilometres where it is long. */
export function distance(metres: number): string {
  if (metres < 1000) return quantity(metres, metres < 10 ? 1 : 0, "m");
  return quantity(metres / 1000, metres < 10_000 ? 2 : 1, "km");
}

/** Direction in whole degrees, three digits as radio traffic has them: 007°. */
export const bearing = (degrees: number): string => `${String(Math.round(degrees) % 360).padStart(3, "0")}°`;

/** Moment as date and time at this screen, with its time zone. */
export const dateAndTime = (utc_s: number): string =>
  `${new Date(1000 * utc_s).toLocaleDateString("sv")} ${timeOfDay(utc_s)}`;

/** Age: short ones with a decimal, long ones in minutes, hours or days. */
export function age(seconds: number | null): string {
  if (seconds === null) return UNKNOWN;
  if (seconds < 10) return quantity(seconds, 1, "s");
  if (seconds < 120) return quantity(seconds, 0, "s");
  const [unit, length_s] = AGE_UNITS.find(([, , until_s]) => seconds < until_s) ?? LONGEST_AGE_UNIT;
  return quantity(seconds / length_s, 0, unit);
}

/** Units of long ages, their lengths in seconds, and up to which age they are used. */
const LONGEST_AGE_UNIT = ["d", 86_400, Infinity] as const;
const AGE_UNITS = [["min", 60, 7200], ["h", 3600, 172_800], LONGEST_AGE_UNIT] as const;

/** MAVLink's GPS_FIX_TYPE. */
export function gpsFix(fix: number | null): string {
  return fix === null ? UNKNOWN : (texts.names.gpsFix[fix] ?? String(fix));
}

/** East and north of the origin. */
export function eastNorth(east_m: number, north_m: number): string {
  return `E ${quantity(east_m, 1, "m")}, N ${quantity(north_m, 1, "m")}`;
}

/** Numbers in ascending order with consecutive ones as ranges: "1–4, 7". */
export function ranges(ids: readonly number[]): string {
  const runs: [number, number][] = [];
  for (const id of ids.toSorted((a, b) => a - b)) {
    const last = runs.at(-1);
    if (last !== undefined && id === last[1] + 1) last[1] = id;
    else runs.push([id, id]);
  }
  return runs.map(([from, to]) => (from === to ? `${from}` : `${from}–${to}`)).join(", ");
}

/** Text with a capital first letter, as labels have. */
export const capitalised = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** Display name of an identifier; an unknown identifier is shown in plain letters. */
export const displayName = (names: Readonly<Record<string, string>>, identifier: string): string =>
  names[identifier] ?? capitalised(identifier.replaceAll("_", " "));
