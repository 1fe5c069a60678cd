/** Vehicles of the fleet as they are listed: filtered, and in an order that does not change under the pointer. */
import type { Vehicle } from "../../api/types";
import { type Attention, attentionOf, isAirborne, isBatteryLow, type Level, worstFirst } from "../../state/attention";
import type { Order } from "./fleet_settings";

export const FILTERS = ["all", "attention", "airborne", "battery"] as const;
export type Filter = (typeof FILTERS)[number];

export interface Row {
  readonly vehicle: Vehicle;
  readonly attention: Attention;
  /**
   * Level when the mission was heard last, by which rows are listed: once it falls silent, all vehicles do, and an order
   * by that would move the rows and hide who was in trouble before.
   */
  readonly reported: Level;
}

/** All vehicles with what they need, in the order of their numbers. */
export const makeRows = (vehicles: readonly Vehicle[], snapshotAge_s: number): Row[] =>
  vehicles.map((vehicle) => ({
    vehicle,
    attention: attentionOf(vehicle, snapshotAge_s),
    reported: attentionOf(vehicle, 0).level,
  }));

const PASSES: Readonly<Record<Filter, (row: Row) => boolean>> = {
  all: () => true,
  attention: ({ reported }) => reported !== "good",
  airborne: ({ vehicle }) => isAirborne(vehicle),
  battery: ({ vehicle }) => isBatteryLow(vehicle),
};

/** Number of vehicles that each filter lets pass. */
export function countRows(rows: readonly Row[]): Readonly<Record<Filter, number>> {
  const count = (filter: Filter): number => rows.filter(PASSES[filter]).length;
  return { all: rows.length, attention: count("attention"), airborne: count("airborne"), battery: count("battery") };
}

/** Ids of the vehicles that a filter lets pass, in the chosen order. */
export function orderedIds(rows: readonly Row[], filter: Filter, order: Order): number[] {
  const ids = rows.filter(PASSES[filter]).map(({ vehicle }) => vehicle.vehicle_id);
  if (order === "number") return ids;
  const levels = new Map<number, Level>(rows.map(({ vehicle, reported }) => [vehicle.vehicle_id, reported]));
  return worstFirst(levels, ids);
}

/** The former order with what is no longer listed left out and what is new at its end. */
export function steadyOrder(former: readonly number[], ids: readonly number[]): readonly number[] {
  const kept = former.filter((id) => ids.includes(id));
  return [...kept, ...ids.filter((id) => !kept.includes(id))];
}
