/** Tiles of the wall: names, choice and layout. Pure functions. */
import { texts } from "../../texts";

export type Kind = keyof typeof texts.wall.kind;

export interface Tile {
  readonly name: string;
  /** Null: the integral of all cameras. */
  readonly vehicleId: number | null;
  readonly kind: Kind;
}

/** Greatest number of tiles that a page may watch; the station refuses more. */
export const MOST_TILES = 24;
const FIRST_TILES = 6;
/** Height of the lines below a picture, and the ratio of its sides. */
const CAPTION_PX = 76;
const ASPECT = 4 / 3;

/** Tile of a name such as `3.thermal` or `all.colour`; null for what is none. */
export function tileOf(name: string): Tile | null {
  const [, of, kind] = /^(all|\d{1,3})\.(colour|thermal)$/.exec(name) ?? [];
  if (of === undefined || kind === undefined) return null;
  return { name, vehicleId: of === "all" ? null : Number(of), kind: kind as Kind };
}

export const tilesOf = (names: readonly string[]): Tile[] =>
  names.map(tileOf).filter((tile): tile is Tile => tile !== null);

export function titleOf({ vehicleId, kind }: Tile): string {
  const of = vehicleId === null ? texts.wall.integral : texts.wall.vehicle(vehicleId);
  return texts.wall.title(of, texts.wall.kind[kind]);
}

/** Tiles of a screen that has not chosen: the integrals, and the first cameras, each by what shows persons best. */
export function firstTiles(there: readonly string[]): string[] {
  const tiles = tilesOf(there);
  const best = new Map<number | null, string>();
  for (const { vehicleId, kind, name } of tiles) {
    if (vehicleId !== null && (kind === "thermal" || !best.has(vehicleId))) best.set(vehicleId, name);
  }
  const integrals = tiles.filter(({ vehicleId }) => vehicleId === null).map(({ name }) => name);
  return [...integrals, ...best.values()].slice(0, FIRST_TILES);
}

/** Number of columns in which so many tiles are as large as possible in a space. */
export function columnsFor(count: number, width_px: number, height_px: number, least_px: number): number {
  const most = Math.max(1, Math.floor(width_px / least_px));
  let best = { columns: 1, size_px: 0 };
  for (let columns = 1; columns <= Math.min(most, Math.max(1, count)); columns += 1) {
    const rows = Math.ceil(count / columns);
    const size_px = Math.min(width_px / columns, (height_px / rows - CAPTION_PX) * ASPECT);
    if (size_px > best.size_px) best = { columns, size_px };
  }
  // Where nothing fits, the page scrolls.
  return best.size_px < least_px ? most : best.columns;
}
