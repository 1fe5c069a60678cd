/** The table of vehicles; a selected row limits the commands to it. */
import type { Mission, Vehicle } from "../api/types";
import { age, gpsFix, quantity, words } from "../format";
import { vehicleColour } from "../map/palette";
import { isStale, linkAge_s } from "../state/freshness";
import { texts } from "../texts";

const LOW_BATTERY_PERCENT = 25;

interface Props {
  mission: Mission | null;
  snapshotAge_s: number;
  selected: ReadonlySet<number>;
  onSelect(vehicleId: number): void;
}

export function VehicleTable({ mission, snapshotAge_s, selected, onSelect }: Props) {
  const { columns, none, panel } = texts.vehicles;
  const vehicles = mission?.vehicles ?? [];
  return (
    <section class="vehicles panel" aria-label={panel} data-testid="vehicles">
      {vehicles.length === 0 ? (
        <p class="empty">{none}</p>
      ) : (
        <table>
          <thead>
            <tr>
              {Object.entries(columns).map(([key, name]) => (
                <th key={key} scope="col" class={`col-${key}`}>
                  {key === "select" ? <span class="visually-hidden">{name}</span> : name}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {vehicles.map((vehicle) => (
              <Row
                key={vehicle.vehicle_id}
                vehicle={vehicle}
                snapshotAge_s={snapshotAge_s}
                isSelected={selected.has(vehicle.vehicle_id)}
                onSelect={() => onSelect(vehicle.vehicle_id)}
              />
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}

interface RowProps {
  vehicle: Vehicle;
  snapshotAge_s: number;
  isSelected: boolean;
  onSelect(): void;
}

function Row({ vehicle, snapshotAge_s, isSelected, onSelect }: RowProps) {
  const { vehicle_id: id } = vehicle;
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  const stale = isStale(vehicle, snapshotAge_s);
  const classes = `${isSelected ? "is-selected" : ""} ${stale ? "is-stale" : ""}`;
  const isLow = vehicle.battery_percent !== null && vehicle.battery_percent < LOW_BATTERY_PERCENT;
  const problem = vehicle.refusal ?? vehicle.text;
  return (
    <tr class={classes} data-testid={`vehicle-${id}`} data-stale={stale} onClick={onSelect}>
      <td class="col-select">
        <input
          type="checkbox"
          data-testid={`select-${id}`}
          aria-label={texts.vehicles.selectRow(id)}
          checked={isSelected}
          onClick={(event) => event.stopPropagation()}
          onChange={onSelect}
        />
      </td>
      <th scope="row" class="col-id">
        <i class="swatch" style={{ background: vehicleColour(id) }} />
        {id}
      </th>
      <td title={vehicle.mode_name}>{vehicle.mode === "unknown" ? quantity(null, 0) : vehicle.mode}</td>
      <td data-testid={`task-${id}`}>{words(vehicle.task)}</td>
      <td>{armedWord(vehicle)}</td>
      <td class={`number ${isLow ? "is-bad" : ""}`}>{quantity(vehicle.battery_percent, 0, "%")}</td>
      <td>{gpsWords(vehicle)}</td>
      <td class="number" data-testid={`link-${id}`}>
        {age_s === null ? texts.vehicles.neverHeard : age(age_s)}
      </td>
      <td class="number" data-testid={`height-${id}`}>
        {quantity(vehicle.height_above_home_m, 1, "m")}
      </td>
      <td class="number">{quantity(vehicle.ground_speed_mps, 1, "m/s")}</td>
      <td class={`col-message ${problem ? "is-warning" : ""}`} title={problem}>
        {problem}
      </td>
    </tr>
  );
}

function armedWord({ armed }: Vehicle): string {
  if (armed === null) return quantity(null, 0);
  return armed ? texts.vehicles.armed : texts.vehicles.disarmed;
}

function gpsWords({ gps_fix: fix, satellites }: Vehicle): string {
  return satellites === null ? gpsFix(fix) : `${gpsFix(fix)} · ${satellites}`;
}
