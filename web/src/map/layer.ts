/** Interface of map layers, and the most common one: features computed from the scene. */
import type { Feature } from "geojson";
import type { FilterSpecification, LayerSpecification, Map as MapLibreMap } from "maplibre-gl";
import type { Geodetic, Mission, PictureKind } from "../api/types";
import type { State } from "../state/state";
import { joinSource, LAYER_PROPERTY } from "./feature_source";
import type { Palette } from "./palette";

/** Data that layers can draw. */
export interface Scene {
  readonly origin: Geodetic;
  readonly mission: Mission;
  readonly state: State;
  readonly snapshotAge_s: number;
  readonly selected: ReadonlySet<number>;
  /** Image on the ground. */
  readonly overlay: Overlay | null;
}

export interface Overlay {
  readonly kind: PictureKind;
  /** Between 0 and 1. */
  readonly opacity: number;
}

export interface MapLayer {
  readonly id: string;
  /** Whose map it is, which has to be shown with it. */
  readonly attribution?: string;
  /** Add the layer on top of a map; called again when the theme changes. */
  attach(map: MapLibreMap, palette: Palette): AttachedLayer;
}

export interface AttachedLayer {
  /** Called after every change of the scene: must be cheap when its own part is unchanged. */
  update(scene: Scene): void;
  remove(): void;
}

/** A style layer without its id and its source, which {@link featureLayer} adds. */
type WithoutSource<T> = T extends unknown ? Omit<T, "id" | "source"> : never;
type Paint = WithoutSource<Exclude<LayerSpecification, { type: "background" | "raster" | "hillshade" }>>;

interface FeatureLayer {
  readonly id: string;
  /** Source shared with neighbouring layers that change about as often; by default one of its own. */
  readonly source?: string;
  /** Style of the features, bottom up. */
  paint(palette: Palette): readonly Paint[];
  /** Values that the features depend on; the features are computed again only when one of these changes. */
  inputs(scene: Scene): readonly unknown[];
  features(scene: Scene): readonly Feature[];
  /** Shortest interval between updates, for what need not be exact to a fraction of a second. */
  readonly interval_ms?: number;
  /** Called with the property `id` of a clicked feature. */
  onClick?(id: number, event: MouseEvent): void;
}

/** Layer of GeoJSON features. Only changed sources are sent to the worker of the map. */
export function featureLayer({
  id,
  source = id,
  paint,
  inputs,
  features,
  interval_ms = 0,
  onClick,
}: FeatureLayer): MapLayer {
  return {
    id,
    attach(map, palette) {
      const shared = joinSource(map, source, id);
      const layerIds = paint(palette).map((part, index) => {
        const layerId = `${id}-${index}`;
        map.addLayer({ ...part, id: layerId, source, filter: filterOf(id, part) } as LayerSpecification);
        return layerId;
      });
      const stopClicks = onClick === undefined ? () => undefined : followClicks(map, layerIds, onClick);
      let drawn: readonly unknown[] | null = null;
      let drawnAtMs = -Infinity;
      return {
        update(scene) {
          const wanted = inputs(scene);
          if (drawn !== null && wanted.every((value, index) => Object.is(value, drawn?.[index]))) return;
          const nowMs = performance.now();
          if (nowMs - drawnAtMs < interval_ms) return; // the next update follows soon
          drawn = wanted;
          drawnAtMs = nowMs;
          shared.set(features(scene));
        },
        remove() {
          stopClicks();
          for (const layerId of layerIds) map.removeLayer(layerId);
          shared.leave();
        },
      };
    },
  };
}

function filterOf(layerId: string, { filter }: Paint): FilterSpecification {
  const isOfLayer: FilterSpecification = ["==", ["get", LAYER_PROPERTY], layerId];
  return filter === undefined ? isOfLayer : (["all", isOfLayer, filter] as FilterSpecification);
}

function followClicks(
  map: MapLibreMap,
  layerIds: string[],
  onClick: (id: number, event: MouseEvent) => void,
): () => void {
  const subscriptions = [
    map.on("click", layerIds, ({ features, originalEvent }) => {
      const id: unknown = features?.[0]?.properties["id"];
      if (typeof id === "number") onClick(id, originalEvent);
    }),
    map.on("mouseenter", layerIds, () => (map.getCanvas().style.cursor = "pointer")),
    map.on("mouseleave", layerIds, () => (map.getCanvas().style.cursor = "")),
  ];
  return () => subscriptions.forEach((subscription) => subscription.unsubscribe());
}
