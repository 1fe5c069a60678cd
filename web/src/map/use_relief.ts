/** Hook for the layers of the relief, which the station makes anew when the plan moves the mission. */
import { useEffect, useState } from "preact/hooks";
import { readContours, readRelief } from "../api/relief";
import { useShell } from "../shell/context";
import type { State } from "../state/state";
import { chosenUnits } from "../units";
import type { MapLayer } from "./layer";
import { contoursLayer, shadingLayer } from "./layers/relief";

interface Drawn {
  /** Address of the contour lines, which changes with the relief and with the units. */
  readonly url: string | null;
  readonly layers: readonly MapLayer[];
}

const NOTHING: Drawn = { url: null, layers: [] };

/** What was read last, for views that are opened again. */
let last: { readonly place: string; readonly drawn: Drawn } | null = null;

export function useReliefLayers(): readonly MapLayer[] {
  const { state, isConnected } = useShell();
  const place = placeOf(state);
  const [drawn, setDrawn] = useState(last?.drawn ?? NOTHING);
  useEffect(() => {
    if (place === null || !isConnected || last?.place === place) return undefined;
    let isWanted = true;
    void read(last?.drawn ?? NOTHING).then((found) => {
      if (!isWanted || found === null) return;
      last = { place, drawn: found };
      setDrawn(found);
    });
    return () => {
      isWanted = false;
    };
  }, [place, isConnected]);
  return drawn.layers;
}

/** What the relief and its lines depend on; null while there is none. */
function placeOf({ mission, planRevision }: State): string | null {
  if (mission === null || mission.origin === null) return null;
  return JSON.stringify([mission.mission_id, mission.origin, mission.fence, planRevision, chosenUnits()]);
}

/** Layers by the station; those that are drawn if nothing has changed, null if it does not answer. */
async function read(drawn: Drawn): Promise<Drawn | null> {
  const relief = await readRelief();
  if (!relief.ok) {
    // A model that cannot be used is named by preflight and by the check of the plan.
    return relief.status === undefined ? null : NOTHING;
  }
  const { shading_url, contours_url, contours_ft_url, corners } = relief.value;
  const url = chosenUnits() === "imperial" ? contours_ft_url : contours_url;
  if (shading_url === null || url === null) return NOTHING;
  if (url === drawn.url) return drawn;
  const contours = await readContours(url);
  if (!contours.ok) return null;
  const layers = [shadingLayer(shading_url, corners), contoursLayer(contours.value)];
  return { url, layers: layers.filter((layer): layer is MapLayer => layer !== null) };
}
