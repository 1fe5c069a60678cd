/**
 * Base map that the operator has chosen on this screen: a PMTiles file of this computer, kept until the page is loaded
 * again. It is read in parts where it lies: nothing is uploaded, and files of any size can be shown.
 */
import { useEffect, useState } from "preact/hooks";
import { texts } from "../texts";
import type { MapLayer } from "./layer";
import { BASEMAP_LIBRARY } from "./library";

export const SUFFIX = ".pmtiles";

interface ChosenBasemap {
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
    const { openBasemapFile } = await BASEMAP_LIBRARY.load();
    change({ chosen: { name: file.name, layer: await openBasemapFile(file) }, refusal: null });
  } catch (error) {
    console.warn("The chosen base map cannot be shown.", error);
    change({ ...state, refusal: texts.map.notBasemap(file.name) });
  }
}

/** Show the station's map again. */
export const forgetBasemap = (): void => change({ chosen: null, refusal: null });

function change(next: State): void {
  state = next;
  for (const follow of followers) follow(next);
}
