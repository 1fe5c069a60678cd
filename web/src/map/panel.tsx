/** Map of a view, with its controls; without WebGL a message instead. */
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { written } from "../coordinates";
import { eastNorth } from "../format";
import { type LngLat, placeAt } from "../geometry";
import { useShell } from "../shell/context";
import type { ViewName } from "../shell/route";
import type { EnuPoint } from "../state/state";
import { texts } from "../texts";
import { usePart } from "../ui/part";
import { chooseBasemap, SUFFIX } from "./chosen_basemap";
import type { MapLayer, Overlay } from "./layer";
import { MAP_LIBRARY, type MapView } from "./library";
import type { Camera } from "./view";

interface Props {
  /** Layers, bottom up. Other objects redraw the map from scratch: make them once. */
  layers: readonly MapLayer[];
  overlay?: Overlay | null;
  /** Further places that "Fit to fleet" shows. */
  extent?: readonly EnuPoint[];
  /** Place to show whenever it changes. */
  lookAt?: EnuPoint | null;
  /** Further controls. */
  children?: ComponentChildren;
}

/** Camera positions that the operator has chosen, by view, to be restored. */
const lastCameras = new Map<ViewName, { missionId: string; camera: Camera }>();

export function MapPanel({ layers, overlay = null, extent = [], lookAt = null, children }: Props) {
  const { state, theme, notation, selection, snapshotAge_s, route, isSurvey } = useShell();
  const container = useRef<HTMLDivElement>(null);
  const view = useRef<MapView | null>(null);
  const [isPossible] = useState(hasWebGl);
  const library = usePart(MAP_LIBRARY);
  const { mission } = state;
  const origin = mission?.origin ?? null;
  const hasOrigin = origin !== null;
  const [cursor, setCursor] = useState<{ enu: EnuPoint; lngLat: LngLat } | null>(null);

  useEffect(() => {
    if (!isPossible || !library || !container.current || !mission || !origin) return undefined;
    const missionId = mission.mission_id;
    const { view: name } = route;
    const last = lastCameras.get(name);
    const camera = last?.missionId === missionId ? last.camera : null;
    const made = new library.MapView(container.current, origin, theme, camera, { onCursor: setCursor });
    view.current = made;
    return () => {
      if (made.camera !== null) lastCameras.set(name, { missionId, camera: made.camera });
      made.remove();
      view.current = null;
    };
    // The view is made once there is an origin; later changes reach it by update().
  }, [hasOrigin, isPossible, library]);

  useEffect(() => {
    if (!mission || !origin) return;
    view.current?.update(layers, { origin, mission, state, snapshotAge_s, selected: selection.ids, overlay }, theme);
  });

  const attribution = layers.flatMap((layer) => layer.attribution ?? []).join(" · ");

  useEffect(() => {
    if (lookAt !== null) view.current?.lookAt(lookAt);
  }, [lookAt?.join(), hasOrigin, library]);

  return (
    <section
      class="map panel"
      aria-label={texts.map.panel}
      data-testid="map"
      onDragOver={(event) => event.preventDefault()}
      onDrop={takeBasemap}
    >
      {isPossible && hasOrigin ? (
        <>
          <div class="map-canvas" ref={container} />
          <div class="map-controls">
            <button type="button" data-testid="map-fit" onClick={() => view.current?.fitFleet(extent)}>
              {isSurvey ? texts.survey.fit : texts.map.fit}
            </button>
            {children}
          </div>
          {attribution !== "" && (
            <p class="map-attribution" data-testid="map-attribution">
              {attribution}
            </p>
          )}
          <output class="map-cursor" data-testid="map-cursor" aria-label={texts.map.cursor}>
            {cursor && (
              <>
                <b>{written(placeAt(cursor.lngLat), notation)}</b> {eastNorth(cursor.enu[0], cursor.enu[1])}
              </>
            )}
          </output>
        </>
      ) : (
        <p class="empty" data-testid="map-message">
          {isPossible ? texts.map.noOrigin : texts.map.noWebGl}
        </p>
      )}
    </section>
  );
}

/** Whether the browser can draw the map. */
function hasWebGl(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

/** Show a base map that is dropped; other files are left to the view. */
function takeBasemap(event: DragEvent): void {
  event.preventDefault(); // otherwise the browser leaves the page to show the file
  const file = event.dataTransfer?.files[0];
  if (!file?.name.toLowerCase().endsWith(SUFFIX)) return;
  event.stopPropagation();
  void chooseBasemap(file);
}
