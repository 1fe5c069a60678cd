/** How the fleet is shown on this screen: as tiles or a table, in which order, with which columns. Pure functions. */
import { readStored, store } from "../../storage";

export const LAYOUTS = ["tiles", "table"] as const;
export type Layout = (typeof LAYOUTS)[number];
export const ORDERS = ["worst", "number"] as const;
export type Order = (typeof ORDERS)[number];
/** Columns that may be left out; the number of a vehicle always stays. */
export const COLUMNS = ["mode", "task", "armed", "battery", "gps", "link", "height", "message"] as const;
export type Column = (typeof COLUMNS)[number];

export interface FleetSettings {
  /** Null: as the sizes of the fleet and the screen suggest. */
  readonly layout: Layout | null;
  readonly order: Order;
  readonly columns: readonly Column[];
}

const KEY = "aos-gcs-fleet";
const DEFAULTS: FleetSettings = { layout: null, order: "worst", columns: COLUMNS };
/** Rows of a larger fleet do not fit on any screen, its tiles do. */
const MOST_ROWS = 20;
/** Widest screen of a phone, as the styles have it: a table would have its messages beyond the edge there. */
const PHONE_PX = 600;

export const layoutOf = ({ layout }: FleetSettings, vehicles: number, screen_px: number): Layout =>
  layout ?? (vehicles > MOST_ROWS || screen_px <= PHONE_PX ? "tiles" : "table");

/** Settings of a stored text; what this page does not know is left out. */
export function readSettings(stored: string | null): FleetSettings {
  let found: unknown;
  try {
    found = JSON.parse(stored ?? "null");
  } catch {
    return DEFAULTS; // not written by this page
  }
  if (typeof found !== "object" || found === null) return DEFAULTS;
  const values: Readonly<Record<string, unknown>> = { ...found };
  const columns: unknown = values["columns"];
  return {
    layout: LAYOUTS.find((layout) => layout === values["layout"]) ?? DEFAULTS.layout,
    order: ORDERS.find((order) => order === values["order"]) ?? DEFAULTS.order,
    columns: Array.isArray(columns) ? COLUMNS.filter((column) => columns.includes(column)) : DEFAULTS.columns,
  };
}

export const storedSettings = (): FleetSettings => readSettings(readStored(KEY));
export const storeSettings = (settings: FleetSettings): void => store(KEY, JSON.stringify(settings));
