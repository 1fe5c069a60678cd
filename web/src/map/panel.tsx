/** The map with its controls; without WebGL a sentence instead. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { PictureKind } from "../api/types";
import { eastNorth, latLon } from "../format";
import type { LngLat } from "../geometry";
import type { EnuPoint, State } from "../state/state";
import { texts } from "../texts";
import type { Theme } from "./palette";
import { hasWebGl, MapView } from "./view";

const KINDS: readonly PictureKind[] = ["integral", "thermal", "anomaly"];

interface Props {
  state: State;
  theme: Theme;
  selected: ReadonlySet<number>;
  onSelect(vehicleId: number): void;
}

export function MapPanel({ state, theme, selected, onSelect }: Props) {
  const container = useRef<HTMLDivElement>(null);
  const view = useRef<MapView | null>(null);
  const select = useRef(onSelect);
  select.current = onSelect;
  const [isPossible] = useState(hasWebGl);
  const [layer, setLayer] = useState<PictureKind | null>("integral");
  const [opacity, setOpacity] = useState(0.85);
  const [cursor, setCursor] = useState<{ enu: EnuPoint; lngLat: LngLat } | null>(null);
  const { mission } = state;
  const hasOrigin = mission?.origin != null;

  useEffect(() => {
    if (!isPossible || !container.current || !mission?.origin) return undefined;
    const made = new MapView(container.current, mission.origin, theme, {
      onSelect: (id) => select.current(id),
      onCursor: setCursor,
    });
    view.current = made;
    return () => {
      made.remove();
      view.current = null;
    };
    // The view is made once there is an origin; later changes reach it through update().
  }, [hasOrigin, isPossible]);

  useEffect(() => {
    if (mission) view.current?.update(mission, state, { theme, layer, opacity, selected });
  }, [state, theme, layer, opacity, selected]);

  if (!isPossible || !hasOrigin) {
    const text = isPossible ? texts.map.noOrigin : texts.map.noWebGl;
    return (
      <section class="map panel" aria-label={texts.map.panel} data-testid="map">
        <p class="empty" data-testid="map-message">
          {text}
        </p>
      </section>
    );
  }
  return (
    <section class="map panel" aria-label={texts.map.panel} data-testid="map">
      <div class="map-canvas" ref={container} />
      <div class="map-controls">
        <button type="button" data-testid="map-fit" onClick={() => view.current?.fitFleet()}>
          {texts.map.fit}
        </button>
        <label>
          {texts.map.layer}
          <select
            data-testid="map-layer"
            value={layer ?? ""}
            onChange={(event) => setLayer(KINDS.find((kind) => kind === event.currentTarget.value) ?? null)}
          >
            <option value="">{texts.map.noLayer}</option>
            {KINDS.map((kind) => (
              <option key={kind} value={kind}>
                {texts.pictures.kind[kind]}
              </option>
            ))}
          </select>
        </label>
        <input
          type="range"
          min="0"
          max="1"
          step="0.05"
          data-testid="map-opacity"
          aria-label={texts.map.opacity}
          title={texts.map.opacity}
          disabled={layer === null}
          value={opacity}
          onInput={(event) => setOpacity(Number(event.currentTarget.value))}
        />
      </div>
      <Legend />
      <output class="map-cursor" data-testid="map-cursor" aria-label={texts.map.cursor}>
        {cursor && (
          <>
            <b>{eastNorth(cursor.enu[0], cursor.enu[1])}</b> {latLon(cursor.lngLat[1], cursor.lngLat[0])}
          </>
        )}
      </output>
    </section>
  );
}

function Legend() {
  const entries = Object.entries(texts.map.legend);
  return (
    <ul class="map-legend" aria-hidden="true">
      {entries.map(([role, text]) => (
        <li key={role} class={`legend-${role}`}>
          {text}
        </li>
      ))}
    </ul>
  );
}
