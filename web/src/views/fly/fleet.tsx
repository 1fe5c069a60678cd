/** Fleet as a table; commands go to the selected rows. */
import { useMemo } from "preact/hooks";
import type { Vehicle } from "../../api/types";
import { age, gpsFix, quantity, UNKNOWN } from "../../format";
import { vehicleColour } from "../../map/palette";
import { useShell } from "../../shell/context";
import { isStale, linkAge_s } from "../../state/freshness";
import { allHeights, heightWords } from "../../state/heights";
import { extend, toggle } from "../../state/selection";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { useAtMostEvery } from "../../ui/pacing";

const LOW_BATTERY_PERCENT = 25;
const HIGH_LOSS_PERCENT = 5;
/** Numbers that change faster cannot be read; the map shows every change. */
const READING_INTERVAL_MS = 500;

const NO_VEHICLES: readonly Vehicle[] = [];

export function FleetPanel() {
  const { state, snapshotAge_s, selection, changeSelection } = useShell();
  const vehicles = useAtMostEvery(state.mission?.vehicles ?? NO_VEHICLES, READING_INTERVAL_MS);
  const rows = useMemo(() => {
    const fleet = vehicles.map((vehicle) => vehicle.vehicle_id);
    return vehicles.map((vehicle) => (
      <Row
        key={vehicle.vehicle_id}
        vehicle={vehicle}
        snapshotAge_s={snapshotAge_s}
        isSelected={selection.ids.has(vehicle.vehicle_id)}
        onPick={(id, isRange) =>
          changeSelection((before) => (isRange ? extend(before, id, fleet) : toggle(before, id)))
        }
      />
    ));
    // Ages advance in whole seconds while no data arrive.
  }, [vehicles, selection.ids, Math.floor(snapshotAge_s)]);
  return (
    <Panel title={texts.fleet.panel} testId="vehicles" class="fleet">
      {vehicles.length === 0 ? (
        <p class="empty">{texts.fleet.none}</p>
      ) : (
        <div class="scroll" tabIndex={0} role="region" aria-label={texts.fleet.panel}>
          <table>
            <thead>
              <tr>
                {Object.entries(texts.fleet.columns).map(([key, name]) => (
                  <th key={key} scope="col" class={`col-${key}`}>
                    {key === "select" ? <span class="visually-hidden">{name}</span> : name}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>{rows}</tbody>
          </table>
        </div>
      )}
    </Panel>
  );
}

interface RowProps {
  vehicle: Vehicle;
  snapshotAge_s: number;
  isSelected: boolean;
  onPick(id: number, isRange: boolean): void;
}

function Row({ vehicle, snapshotAge_s, isSelected, onPick }: RowProps) {
  const { vehicle_id: id, position, battery_percent: battery, packet_loss_percent: loss } = vehicle;
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  const stale = isStale(vehicle, snapshotAge_s);
  const problem = vehicle.refusal ?? vehicle.text;
  return (
    <tr
      class={`${isSelected ? "is-selected" : ""} ${stale ? "is-stale" : ""}`}
      data-testid={`vehicle-${id}`}
      data-stale={stale}
      data-east={position?.east_m.toFixed(2)}
      data-north={position?.north_m.toFixed(2)}
      onClick={(event) => onPick(id, event.shiftKey)}
    >
      <td class="col-select">
        <input
          type="checkbox"
          data-testid={`select-${id}`}
          aria-label={texts.fleet.selectRow(id)}
          checked={isSelected}
          onClick={(event) => {
            event.stopPropagation();
            onPick(id, event.shiftKey);
          }}
        />
      </td>
      <th scope="row" class="col-id">
        <i class="swatch" style={{ background: vehicleColour(id) }} />
        {id}
      </th>
      <td title={vehicle.mode_name}>{vehicle.mode === "unknown" ? <NoData /> : texts.names.mode[vehicle.mode]}</td>
      <td data-testid={`task-${id}`}>{texts.names.task[vehicle.task]}</td>
      <td>{armedWord(vehicle)}</td>
      <Quantity value={battery} unit="%" isBad={battery !== null && battery < LOW_BATTERY_PERCENT} />
      <td>{gpsWords(vehicle)}</td>
      <td
        class={`number ${loss !== null && loss > HIGH_LOSS_PERCENT ? "is-bad" : ""}`}
        title={texts.fleet.linkHint}
        data-testid={`link-${id}`}
      >
        {age_s === null ? texts.fleet.neverHeard : linkWords(age_s, loss, vehicle.link?.round_trip_ms ?? null)}
      </td>
      <td class="number" title={allHeights(vehicle)} data-testid={`height-${id}`}>
        {vehicle.height_above_home_m === null ? <NoData /> : heightWords(vehicle)}
      </td>
      <td class={`col-message ${problem ? "is-warning" : ""}`} title={problem}>
        {problem}
      </td>
    </tr>
  );
}

interface QuantityProps {
  value: number | null;
  unit: string;
  isBad: boolean;
}

function Quantity({ value, unit, isBad }: QuantityProps) {
  return <td class={`number ${isBad ? "is-bad" : ""}`}>{value === null ? <NoData /> : quantity(value, 0, unit)}</td>;
}

/** Dash with words for screen readers: never reported, which is not zero. */
function NoData() {
  return (
    <span class="no-data" role="img" aria-label={texts.noData} title={texts.noData}>
      {UNKNOWN}
    </span>
  );
}

function armedWord({ armed }: Vehicle) {
  if (armed === null) return <NoData />;
  return armed ? texts.fleet.armed : texts.fleet.disarmed;
}

function gpsWords({ gps_fix: fix, satellites }: Vehicle) {
  if (fix === null) return <NoData />;
  return satellites === null ? gpsFix(fix) : `${gpsFix(fix)} · ${satellites}`;
}

function linkWords(age_s: number, loss_percent: number | null, roundTrip_ms: number | null): string {
  const known = [
    age(age_s),
    ...(loss_percent === null ? [] : [quantity(loss_percent, 0, "%")]),
    ...(roundTrip_ms === null ? [] : [quantity(roundTrip_ms, 0, "ms")]),
  ];
  return known.join(" · ");
}
