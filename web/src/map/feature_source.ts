/** GeoJSON sources that several feature layers share. */
import type { Feature } from "geojson";
import type { GeoJSONSource, Map as MapLibreMap } from "maplibre-gl";

/** Property that names the layer of a feature. */
export const LAYER_PROPERTY = "layer";

/** Features of one layer in a source. */
export interface SourcePart {
  /** Replace the features; nothing is drawn again when they are what they were. */
  set(features: readonly Feature[]): void;
  /** Remove the features, and the source with its last part; to be called when no layer uses them any more. */
  leave(): void;
}

type Parts = Map<string, readonly Feature[]>;

const partsOfMaps = new WeakMap<MapLibreMap, Map<string, Parts>>();

/**
 * Join a source of a map; the first layer creates it.
 *
 * Layers share a source because MapLibre passes over the whole map for each source with areas or lines, in every frame:
 * without a graphics card that takes longer than drawing the features.
 */
export function joinSource(map: MapLibreMap, sourceId: string, layerId: string): SourcePart {
  const sources = partsOfMaps.get(map) ?? new Map<string, Parts>();
  partsOfMaps.set(map, sources);
  const parts: Parts = sources.get(sourceId) ?? new Map<string, readonly Feature[]>();
  if (parts.size === 0) map.addSource(sourceId, { type: "geojson", data: collection([]) });
  sources.set(sourceId, parts);
  parts.set(layerId, []);
  let shown = JSON.stringify([]);
  return {
    set(features) {
      // Comparing them takes far less than another frame of the whole map.
      const wanted = JSON.stringify(features);
      if (wanted === shown) return;
      shown = wanted;
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
