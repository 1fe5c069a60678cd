/** Table of all tiles: a row per camera, a column per kind. */
import { texts } from "../../texts";
import { type Kind, MOST_TILES, type Tile, tilesOf, titleOf } from "./tiles";

const KINDS = ["colour", "thermal"] as const satisfies readonly Kind[];

interface Props {
  /** Names of all tiles that there are. */
  there: readonly string[];
  chosen: readonly string[];
  onChoose(tiles: readonly string[]): void;
}

export function TileChoice({ there, chosen, onChoose }: Props) {
  const tiles = tilesOf(there);
  const rows = [...new Set(tiles.map(({ vehicleId }) => vehicleId))];
  const isFull = chosen.length >= MOST_TILES;
  const cell = (tile: Tile | undefined) =>
    tile && (
      <label class="wall-check" title={titleOf(tile)}>
        <input
          type="checkbox"
          data-testid={`choose-${tile.name}`}
          aria-label={titleOf(tile)}
          checked={chosen.includes(tile.name)}
          disabled={isFull && !chosen.includes(tile.name)}
          onChange={() =>
            onChoose(
              chosen.includes(tile.name)
                ? chosen.filter((name) => name !== tile.name)
                : // In the order of the table, whatever was chosen first.
                  there.filter((name) => name === tile.name || chosen.includes(name)),
            )
          }
        />
      </label>
    );
  return (
    <>
      <table class="wall-choice">
        <thead>
          <tr>
            <td />
            {KINDS.map((kind) => (
              <th key={kind} scope="col">
                {texts.wall.kind[kind]}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((vehicleId) => (
            <tr key={vehicleId ?? "all"}>
              <th scope="row">{vehicleId === null ? texts.wall.integral : texts.wall.vehicle(vehicleId)}</th>
              {KINDS.map((kind) => (
                <td key={kind}>{cell(tiles.find((one) => one.vehicleId === vehicleId && one.kind === kind))}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
      {isFull && <p class="small">{texts.wall.most(MOST_TILES)}</p>}
    </>
  );
}
