/** Fleet as tiles: a hundred vehicles on one screen, each with what matters most about it. */
import { quantity } from "../../format";
import { vehicleColour } from "../../map/palette";
import { isStale } from "../../state/freshness";
import { heightWords } from "../../state/heights";
import { texts } from "../../texts";
import type { Row } from "./rows";

interface Props {
  rows: readonly Row[];
  snapshotAge_s: number;
  selected: ReadonlySet<number>;
  onPick(id: number, isRange: boolean): void;
}

export function FleetTiles({ rows, snapshotAge_s, selected, onPick }: Props) {
  return (
    <div class="tiles">
      {rows.map((row) => (
        <Tile
          key={row.vehicle.vehicle_id}
          row={row}
          stale={isStale(row.vehicle, snapshotAge_s)}
          isSelected={selected.has(row.vehicle.vehicle_id)}
          onPick={onPick}
        />
      ))}
    </div>
  );
}

interface TileProps {
  row: Row;
  stale: boolean;
  isSelected: boolean;
  onPick(id: number, isRange: boolean): void;
}

function Tile({ row: { vehicle, attention }, stale, isSelected, onPick }: TileProps) {
  const { vehicle_id: id, task, battery_percent: battery, position } = vehicle;
  const { level, causes } = attention;
  return (
    <button
      type="button"
      class={`tile is-${level} ${isSelected ? "is-selected" : ""} ${stale ? "is-stale" : ""}`}
      aria-pressed={isSelected}
      title={causes.join("; ")}
      data-testid={`vehicle-${id}`}
      data-level={level}
      data-stale={stale}
      data-east={position?.east_m.toFixed(2)}
      data-north={position?.north_m.toFixed(2)}
      onClick={(event) => onPick(id, event.shiftKey)}
    >
      <span class="tile-head">
        <i class="swatch" style={{ background: vehicleColour(id) }} />
        <b>{id}</b> <span data-testid={`task-${id}`}>{texts.names.task[task]}</span>
      </span>
      <span class="tile-words">{causes[0] ?? `${quantity(battery, 0, "%")} · ${heightWords(vehicle)}`}</span>
    </button>
  );
}
