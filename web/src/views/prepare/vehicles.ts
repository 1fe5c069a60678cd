/** Choice of the vehicles that fly. Pure functions. */
import type { Mission, Vehicle } from "../../api/types";

type Candidate = Pick<Vehicle, "vehicle_id" | "takes_part" | "armed">;

/** Ids of the vehicles confirmed already, ascending. */
export const confirmedIds = (vehicles: readonly Candidate[]): number[] =>
  ascending(vehicles.filter((vehicle) => vehicle.takes_part).map((vehicle) => vehicle.vehicle_id));

/** Ids to propose: those confirmed, or else the lowest on the ground, as many as the plan has. */
export function proposedIds(vehicles: readonly Candidate[], planned: number): number[] {
  const confirmed = confirmedIds(vehicles);
  if (confirmed.length > 0) return confirmed;
  const waiting = vehicles.filter((vehicle) => vehicle.armed !== true).map((vehicle) => vehicle.vehicle_id);
  return ascending(waiting).slice(0, planned);
}

/** Whether as many vehicles as planned wait for their confirmation; another number is another plan. */
export const isProposal = (
  {
    vehicles,
    planned_vehicles,
    phase,
  }: Pick<Mission, "planned_vehicles" | "phase"> & {
    readonly vehicles: readonly Candidate[];
  },
  chosen: readonly number[],
): boolean => phase !== "connect" && chosen.length === planned_vehicles && !isSame(chosen, confirmedIds(vehicles));

export const isSame = (one: readonly number[], other: readonly number[]): boolean =>
  one.length === other.length && one.every((id, index) => id === other[index]);

export const ascending = (ids: readonly number[]): number[] => ids.toSorted((a, b) => a - b);
