/**
 * Units of lengths, areas and speeds on this screen. Values are metric everywhere inside; `quantity` and number fields
 * convert them at the edge.
 */
import { readStored, store } from "./storage";

export const UNITS = ["metric", "imperial"] as const;
export type Units = (typeof UNITS)[number];

/** A unit as it is shown, and how many of it are one of the metric unit. */
export interface ShownUnit {
  readonly unit: string;
  readonly factor: number;
}

const KEY = "aos-gcs-units";
const IMPERIAL: Readonly<Record<string, ShownUnit>> = {
  m: { unit: "ft", factor: 1 / 0.3048 },
  km: { unit: "mi", factor: 1 / 1.609344 },
  "m/s": { unit: "mph", factor: 3.6 / 1.609344 },
  "m²": { unit: "ft²", factor: 1 / 0.3048 ** 2 },
  "ha/h": { unit: "ac/h", factor: 10_000 / 4046.8564224 },
  ha: { unit: "ac", factor: 10_000 / 4046.8564224 },
};

// One for the whole page, as its language is: every text with a unit asks for it.
let chosen: Units = "metric";

export const chosenUnits = (): Units => chosen;

/** Show another kind of units from now on; what is on the screen already has to be rendered anew. */
export function chooseUnits(units: Units): void {
  chosen = units;
}

export const storedUnits = (): Units => UNITS.find((units) => units === readStored(KEY)) ?? "metric";
export const storeUnits = (units: Units): void => store(KEY, units);

/** How a metric unit is shown; other units, such as seconds, are the same for all. */
export const shownUnit = (unit: string): ShownUnit =>
  (chosen === "imperial" ? IMPERIAL[unit] : undefined) ?? { unit, factor: 1 };
