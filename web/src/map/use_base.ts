/** Hook for the lowest layers: the base map and the relief of the station if it has them, and the metric grid. */
import { useEffect, useMemo, useState } from "preact/hooks";
import { readBasemap } from "../api/client";
import { untilAnswered } from "../api/persistence";
import type { MapLayer } from "./layer";
import { openBasemap } from "./layers/basemap";
import { gridLayer } from "./layers/grid";
import { useReliefLayers } from "./use_relief";

/** Requested once. */
let opened: Promise<MapLayer | null> | null = null;

async function open(): Promise<MapLayer | null> {
  const basemap = await untilAnswered(readBasemap, () => true);
  if (basemap === null || basemap.url === null) return null;
  try {
    return await openBasemap(basemap.url);
  } catch (error) {
    console.warn("The base map cannot be shown.", error);
    return null;
  }
}

export function useBaseLayers(): readonly MapLayer[] {
  const [basemap, setBasemap] = useState<MapLayer | null>(null);
  const relief = useReliefLayers();
  useEffect(() => {
    opened ??= open();
    void opened.then(setBasemap);
  }, []);
  return useMemo(() => [...(basemap === null ? [] : [basemap]), ...relief, gridLayer], [basemap, relief]);
}
