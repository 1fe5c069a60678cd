/** Hook for the lowest layers: the base map, the relief of the station if it has one, and the metric grid. */
import { useEffect, useMemo, useState } from "preact/hooks";
import { readBasemap } from "../api/client";
import { untilAnswered } from "../api/persistence";
import { useShell } from "../shell/context";
import { useChosenBasemap } from "./chosen_basemap";
import type { MapLayer } from "./layer";
import { faintGridLayer, gridLayer } from "./layers/grid";
import { BASEMAP_LIBRARY } from "./library";
import { useReliefLayers } from "./use_relief";

interface Opened {
  readonly url: string;
  readonly layer: MapLayer | null;
}

/** Base map of the station that was opened last, for views that are opened again. */
let last: Opened | null = null;

/** Base map of the station: asked for with each mission, and in each of its phases until there is one. */
function useStationBasemap(): MapLayer | null {
  const { state, isConnected } = useShell();
  const [opened, setOpened] = useState(last);
  const missionId = state.mission?.mission_id;
  const phase = state.mission?.phase;
  useEffect(() => {
    if (!isConnected) return undefined;
    let isWanted = true;
    void open(() => isWanted).then((found) => {
      if (!isWanted) return;
      last = found;
      setOpened(found);
    });
    return () => {
      isWanted = false;
    };
  }, [missionId, opened === null ? phase : null, isConnected]);
  return opened?.layer ?? null;
}

async function open(isWanted: () => boolean): Promise<Opened | null> {
  const url = (await untilAnswered(readBasemap, isWanted))?.url ?? null;
  if (url === null || url === last?.url) return url === null ? null : last;
  try {
    const { openBasemap } = await BASEMAP_LIBRARY.load();
    return { url, layer: await openBasemap(url) };
  } catch (error) {
    console.warn("The base map cannot be shown.", error);
    return { url, layer: null };
  }
}

export function useBaseLayers(): readonly MapLayer[] {
  const station = useStationBasemap();
  const { chosen } = useChosenBasemap();
  const relief = useReliefLayers();
  const basemap = chosen?.layer ?? station;
  return useMemo(
    () => (basemap === null ? [...relief, gridLayer] : [basemap, ...relief, faintGridLayer]),
    [basemap, relief],
  );
}
