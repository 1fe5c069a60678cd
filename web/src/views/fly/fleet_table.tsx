/** Fleet as a table with the chosen columns. */
import type { VNode } from "preact";
import type { Vehicle } from "../../api/types";
import { age, gpsFix, quantity, UNKNOWN } from "../../format";
import { vehicleColour } from "../../map/palette";
import { HIGH_LOSS_PERCENT, isBatteryLow } from "../../state/attention";
import { isStale, linkAge_s } from "../../state/freshness";
import { allHeights, heightWords } from "../../state/heights";
import { texts } from "../../texts";
import type { Column } from "./fleet_settings";
import type { Row } from "./rows";

/** Number of columns up to which the table fits any panel; a wider one scrolls sideways. */
const MOST_NARROW = 4;

interface Props {
  rows: readonly Row[];
  columns: readonly Column[];
  snapshotAge_s: number;
  selected: ReadonlySet<number>;
  onPick(id: number, isRange: boolean): void;
}

export function FleetTable({ rows, columns, snapshotAge_s, selected, onPick }: Props) {
  return (
    <table class={columns.length > MOST_NARROW ? "is-wide" : ""}>
      <thead>
        <tr>
          <th scope="col" class="col-select">
            <span class="visually-hidden">{texts.fleet.select}</span>
          </th>
          <th scope="col" class="col-id">
            {texts.fleet.id}
          </th>
          {columns.map((column) => (
            <th key={column} scope="col" class={`col-${column}`}>
              {texts.fleet.columns[column]}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <TableRow
            key={row.vehicle.vehicle_id}
            row={row}
            columns={columns}
            snapshotAge_s={snapshotAge_s}
            isSelected={selected.has(row.vehicle.vehicle_id)}
            onPick={onPick}
          />
        ))}
      </tbody>
    </table>
  );
}

interface RowProps {
  row: Row;
  columns: readonly Column[];
  snapshotAge_s: number;
  isSelected: boolean;
  onPick(id: number, isRange: boolean): void;
}

function TableRow({ row, columns, snapshotAge_s, isSelected, onPick }: RowProps) {
  const { vehicle, attention } = row;
  const { vehicle_id: id, position } = vehicle;
  const stale = isStale(vehicle, snapshotAge_s);
  return (
    <tr
      class={`is-${attention.level} ${isSelected ? "is-selected" : ""} ${stale ? "is-stale" : ""}`}
      data-testid={`vehicle-${id}`}
      data-level={attention.level}
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
      {columns.map((column) => CELLS[column](row, snapshotAge_s))}
    </tr>
  );
}

/** Cell of each column. */
const CELLS: Readonly<Record<Column, (row: Row, snapshotAge_s: number) => VNode>> = {
  mode: ({ vehicle: { mode, mode_name } }) => (
    <td key="mode" title={mode_name}>
      {mode === "unknown" ? <NoData /> : texts.names.mode[mode]}
    </td>
  ),
  task: ({ vehicle: { vehicle_id: id, task } }) => (
    <td key="task" data-testid={`task-${id}`}>
      {texts.names.task[task]}
    </td>
  ),
  armed: ({ vehicle }) => <td key="armed">{armedWord(vehicle)}</td>,
  battery: ({ vehicle }) => (
    <Quantity key="battery" value={vehicle.battery_percent} unit="%" isBad={isBatteryLow(vehicle)} />
  ),
  gps: ({ vehicle }) => <td key="gps">{gpsWords(vehicle)}</td>,
  link: ({ vehicle }, snapshotAge_s) => <LinkCell key="link" vehicle={vehicle} snapshotAge_s={snapshotAge_s} />,
  height: ({ vehicle }) => (
    <td key="height" class="number" title={allHeights(vehicle)} data-testid={`height-${vehicle.vehicle_id}`}>
      {vehicle.height_above_home_m === null ? <NoData /> : heightWords(vehicle)}
    </td>
  ),
  message: ({ attention: { level, causes } }) => (
    <td key="message" class={`col-message ${level === "good" ? "" : `is-${level}`}`} title={causes.join("; ")}>
      {causes.join("; ")}
    </td>
  ),
};

function LinkCell({ vehicle, snapshotAge_s }: { vehicle: Vehicle; snapshotAge_s: number }) {
  const { packet_loss_percent: loss, link, vehicle_id: id } = vehicle;
  const age_s = linkAge_s(vehicle, snapshotAge_s);
  return (
    <td
      class={`number ${loss !== null && loss > HIGH_LOSS_PERCENT ? "is-bad" : ""}`}
      title={texts.fleet.linkHint}
      data-testid={`link-${id}`}
    >
      {age_s === null ? texts.fleet.neverHeard : linkWords(age_s, loss, link?.round_trip_ms ?? null)}
    </td>
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
