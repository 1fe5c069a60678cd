/** Hook for the lowest layers: the base map of the station if it has one, and the metric grid. */
import { useEffect, useState } from "preact/hooks";
import { readBasemap } from "../api/client";
import { untilAnswered } from "../api/persistence";
import type { MapLayer } from "./layer";
import { openBasemap } from "./layers/basemap";
import { gridLayer } from "./layers/grid";

const GRID_ALONE: readonly MapLayer[] = [gridLayer];

/** Requested once; without a base map there is the grid only. */
let opened: Promise<readonly MapLayer[]> | null = null;

async function open(): Promise<readonly MapLayer[]> {
  const basemap = await untilAnswered(readBasemap, () => true);
  if (basemap === null || basemap.url === null) return GRID_ALONE;
  try {
    return [await openBasemap(basemap.url), gridLayer];
  } catch (error) {
    console.warn("The base map cannot be shown.", error);
    return GRID_ALONE;
  }
}

export function useBaseLayers(): readonly MapLayer[] {
  const [layers, setLayers] = useState(GRID_ALONE);
  useEffect(() => {
    opened ??= open();
    void opened.then(setLayers);
  }, []);
  return layers;
}
