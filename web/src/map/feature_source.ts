/** GeoJSON sources that several layers of features share. */
import type { Feature } from "geojson";
import type { GeoJSONSource, Map as MapLibreMap } from "maplibre-gl";

/** Names the layer that a feature is of. */
export const LAYER_PROPERTY = "layer";

/** The features of one layer in a source. */
export interface SourcePart {
  /** Draw these instead of the former ones. */
  set(features: readonly Feature[]): void;
  /** Take them away, and the source with the last part of it; to be called when no layer uses them any more. */
  leave(): void;
}

type Parts = Map<string, readonly Feature[]>;

const partsOfMaps = new WeakMap<MapLibreMap, Map<string, Parts>>();

/**
 * Join a source of a map, which is put there by the first.
 *
 * Layers share one because MapLibre passes over the whole map for each source with areas or lines, in every frame:
 * without a graphics card that takes longer than to draw what is in them.
 */
export function joinSource(map: MapLibreMap, sourceId: string, layerId: string): SourcePart {
  const sources = partsOfMaps.get(map) ?? new Map<string, Parts>();
  partsOfMaps.set(map, sources);
  const parts: Parts = sources.get(sourceId) ?? new Map<string, readonly Feature[]>();
  if (parts.size === 0) map.addSource(sourceId, { type: "geojson", data: collection([]) });
  sources.set(sourceId, parts);
  parts.set(layerId, []);
  return {
    set(features) {
      parts.set(
        layerId,
        features.map((one) => marked(one, layerId)),
      );
      map.getSource<GeoJSONSource>(sourceId)?.setData(collection([...parts.values()].flat()));
    },
    leave() {
      parts.delete(layerId);
      if (parts.size > 0) return;
      sources.delete(sourceId);
      map.removeSource(sourceId);
    },
  };
}

function marked(one: Feature, layerId: string): Feature {
  return { ...one, properties: { ...one.properties, [LAYER_PROPERTY]: layerId } };
}

function collection(features: Feature[]): { type: "FeatureCollection"; features: Feature[] } {
  return { type: "FeatureCollection", features };
}
