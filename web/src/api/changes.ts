/** Applies changes to the known state of the mission. */
import type { Changes, Mission, PreflightCheck, Vehicle } from "./types";

const keyOf = (check: PreflightCheck): string => `${check.vehicle_id} ${check.name}`;

function replaced(checks: readonly PreflightCheck[], changed: readonly PreflightCheck[]): PreflightCheck[] {
  const byKey = new Map(changed.map((check) => [keyOf(check), check]));
  return checks.map((check) => byKey.get(keyOf(check)) ?? check);
}

/** Return the mission after the changes. Unchanged parts stay the same objects, so that they are not drawn again. */
export function applyChanges(mission: Mission, changes: Changes): Mission {
  const byId = new Map<number, Vehicle>(mission.vehicles.map((vehicle) => [vehicle.vehicle_id, vehicle]));
  for (const fields of changes.vehicles) {
    const id = fields["vehicle_id"] as number;
    byId.set(id, { ...byId.get(id), ...fields } as Vehicle);
  }
  const vehicles =
    changes.vehicles.length === 0
      ? mission.vehicles
      : [...byId.values()].sort((one, other) => one.vehicle_id - other.vehicle_id);
  const after = { ...mission, ...changes.mission, vehicles };
  return changes.preflight.length === 0 ? after : { ...after, preflight: replaced(after.preflight, changes.preflight) };
}
