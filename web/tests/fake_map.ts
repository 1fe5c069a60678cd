/** As much of a MapLibre map as layers of features need. */
import type { Feature, FeatureCollection } from "geojson";
import type { Map as MapLibreMap } from "maplibre-gl";
import type { MapLayer, Scene } from "../src/map/layer";
import { PALETTES } from "../src/map/palette";
import { INITIAL_STATE } from "../src/state/state";
import { mission } from "./samples";

export class FakeMap {
  readonly sources = new Map<string, { data: FeatureCollection; changes: number }>();
  readonly layers: string[] = [];
  readonly filters = new Map<string, unknown>();
  readonly paints = new Map<string, Record<string, unknown> | undefined>();
  /** What has been set of layers, in order. */
  readonly properties: string[] = [];
  /** Addresses of the images that have been shown, in order. */
  readonly images: string[] = [];
  /** Whether the latest image of each source has arrived. */
  areImagesLoaded = true;

  addSource(id: string, { data, url }: { data: FeatureCollection; url?: string }): void {
    this.sources.set(id, { data, changes: 0 });
    if (url !== undefined) this.images.push(url);
  }
  getSource(id: string) {
    const source = this.sources.get(id);
    return (
      source && {
        setData: (data: FeatureCollection) => this.set(id, data),
        updateImage: ({ url }: { url: string }) => this.images.push(url),
        loaded: () => this.areImagesLoaded,
      }
    );
  }
  removeSource(id: string): void {
    this.sources.delete(id);
  }
  addLayer({ id, filter, paint }: { id: string; filter?: unknown; paint?: Record<string, unknown> }): void {
    this.layers.push(id);
    this.paints.set(id, paint);
    this.filters.set(id, filter);
  }
  getLayer(id: string): string | undefined {
    return this.layers.find((layer) => layer === id);
  }
  removeLayer(id: string): void {
    this.layers.splice(this.layers.indexOf(id), 1);
  }
  setLayoutProperty(_id: string, name: string, value: unknown): void {
    this.properties.push(`${name}: ${String(value)}`);
  }
  setPaintProperty(id: string, name: string, value: unknown): void {
    this.setLayoutProperty(id, name, value);
  }
  /** South-west and north-east of what the map shows, in degrees from its origin. */
  reach_deg = 0.002;
  getBounds() {
    const at = (sign: number) => ({
      lng: ORIGIN.longitude_deg + sign * this.reach_deg,
      lat: ORIGIN.latitude_deg + sign * this.reach_deg,
    });
    return { getSouthWest: () => at(-1), getNorthEast: () => at(1) };
  }
  on() {
    return { unsubscribe: () => undefined };
  }
  attach(layer: MapLayer) {
    return layer.attach(this as unknown as MapLibreMap, PALETTES.dark);
  }
  private set(id: string, data: FeatureCollection): void {
    this.sources.set(id, { data, changes: (this.sources.get(id)?.changes ?? 0) + 1 });
  }
}

export const ORIGIN = { latitude_deg: 48.3358, longitude_deg: 14.3263, altitude_amsl_m: 262 };

export function scene(changes: Partial<Scene> = {}): Scene {
  return {
    origin: ORIGIN,
    mission: mission(),
    state: INITIAL_STATE,
    snapshotAge_s: 0,
    selected: new Set(),
    overlay: null,
    ...changes,
  };
}

/** The features that a layer draws of a scene. */
export function drawn(layer: MapLayer, shown: Scene): Feature[] {
  const map = new FakeMap();
  map.attach(layer).update(shown);
  return [...map.sources.values()].flatMap(({ data }) => data.features);
}
