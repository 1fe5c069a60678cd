/**
 * Base map that the operator has chosen on this screen: a PMTiles file of this computer, kept until the page is loaded
 * again. It is read in parts where it lies: nothing is uploaded, and files of any size can be shown.
 */
import { FileSource, type Header, PMTiles, TileType } from "pmtiles";
import { useEffect, useState } from "preact/hooks";
import { texts } from "../texts";
import type { MapLayer } from "./layer";
import { basemapLayer } from "./layers/basemap";

export const SUFFIX = ".pmtiles";

export interface ChosenBasemap {
  readonly name: string;
  readonly layer: MapLayer;
}

interface State {
  readonly chosen: ChosenBasemap | null;
  /** Reason why the last file cannot be shown. */
  readonly refusal: string | null;
}

let state: State = { chosen: null, refusal: null };
const followers = new Set<(state: State) => void>();
let count = 0;

/** Current base map of this screen, in every view that shows one. */
export function useChosenBasemap(): State {
  const [shown, setShown] = useState(state);
  useEffect(() => {
    followers.add(setShown);
    setShown(state);
    return () => void followers.delete(setShown);
  }, []);
  return shown;
}

/** Show a file; the former map stays if it cannot be shown. */
export async function chooseBasemap(file: File): Promise<void> {
  try {
    const archive = new PMTiles(new NumberedFile(file, ++count));
    const problem = problemOf(await archive.getHeader(), file.size);
    if (problem !== null) throw new Error(problem);
    change({ chosen: { name: file.name, layer: await basemapLayer(archive) }, refusal: null });
  } catch (error) {
    console.warn("The chosen base map cannot be shown.", error);
    change({ ...state, refusal: texts.map.notBasemap(file.name) });
  }
}

/** Show the station's map again. */
export const forgetBasemap = (): void => change({ chosen: null, refusal: null });

/** Reason why an archive cannot be shown, for the log; null if it can. */
export function problemOf(header: Header, size: number): string | null {
  const ends = [
    header.rootDirectoryOffset + header.rootDirectoryLength,
    header.jsonMetadataOffset + header.jsonMetadataLength,
    (header.leafDirectoryOffset ?? 0) + (header.leafDirectoryLength ?? 0),
    (header.tileDataOffset ?? 0) + (header.tileDataLength ?? 0),
  ];
  if (header.specVersion !== VERSION) return `version ${header.specVersion}`;
  if (header.tileType === TileType.Unknown) return "unknown kind of tiles";
  if (![header.internalCompression, header.tileCompression].every((code) => READABLE.includes(code))) {
    return "compression that browsers do not read";
  }
  return ends.some((end) => end > size) ? "incomplete" : null;
}

const VERSION = 3;
/** Numbers of PMTiles for no compression and gzip. */
const READABLE: readonly number[] = [1, 2];

/** File with a key of its own: two files of one name are two maps. */
class NumberedFile extends FileSource {
  constructor(
    file: File,
    private readonly number: number,
  ) {
    super(file);
  }

  override getKey(): string {
    return `file-${this.number}`;
  }
}

function change(next: State): void {
  state = next;
  for (const follow of followers) follow(next);
}
