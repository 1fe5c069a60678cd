/** MapLibre map with its layers. Nothing is loaded from other machines. */
import "maplibre-gl/dist/maplibre-gl.css";
import maplibregl, { type Map as MapLibreMap, type StyleSpecification } from "maplibre-gl";
import type { Geodetic, Mission, Position } from "../api/types";
import { boundsOf, type LngLat, toEnu, toLngLat } from "../geometry";
import type { EnuPoint } from "../state/state";
import { texts } from "../texts";
import type { Theme } from "../theme";
import { chosenUnits } from "../units";
import { gatherDrawings } from "./gathered_drawing";
import { enu } from "./geojson";
import { drawGesturesCoarsely } from "./gesture_drawing";
import type { AttachedLayer, MapLayer, Scene } from "./layer";
import { PALETTES } from "./palette";

export interface MapEvents {
  onCursor(place: { enu: EnuPoint; lngLat: LngLat } | null): void;
}

export interface Camera {
  readonly center: LngLat;
  readonly zoom: number;
}

const FIT_MARGIN_M = 8;
/** Zoom that shows some hundred metres. */
const NEAR_ZOOM = 19;

export class MapView {
  private readonly map: MapLibreMap;
  private isLoaded = false;
  /**
   * Whether the map follows the fleet: until an operator moves it, also when the fleet or the size of the map changes.
   */
  private isFollowing: boolean;
  private located = 0;
  private theme: Theme;
  private layers: readonly MapLayer[] = [];
  private readonly attached = new Map<string, AttachedLayer>();
  private scene: Scene | null = null;
  private readonly endCoarseDrawing: () => void;
  private endGathering = (): void => undefined;

  /** Show the given camera position, or the fleet without one. */
  constructor(container: HTMLElement, origin: Geodetic, theme: Theme, camera: Camera | null, events: MapEvents) {
    maplibregl.setWorkerCount(1);
    this.theme = theme;
    this.isFollowing = camera === null;
    container.style.background = PALETTES[theme].background;
    this.map = new maplibregl.Map({
      container,
      style: EMPTY_STYLE,
      center: camera?.center ?? toLngLat(origin, [0, 0]),
      zoom: camera?.zoom ?? 17,
      maxZoom: 22,
      attributionControl: false,
      dragRotate: false,
      pitchWithRotate: false,
      touchPitch: false,
      renderWorldCopies: false,
      fadeDuration: 0,
      locale: { "Map.Title": texts.map.canvas },
    });
    this.endCoarseDrawing = drawGesturesCoarsely(this.map);
    this.map.touchZoomRotate.disableRotation();
    this.map.addControl(new maplibregl.ScaleControl({ unit: chosenUnits(), maxWidth: 140 }), "bottom-left");
    this.map.addControl(new maplibregl.NavigationControl({ showCompass: false }), "top-right");
    this.map.on("mousemove", ({ lngLat }) => {
      const place: LngLat = [lngLat.lng, lngLat.lat];
      events.onCursor({ lngLat: place, enu: toEnu(this.scene?.origin ?? origin, place) });
    });
    this.map.on("mouseout", () => events.onCursor(null));
    const stopFollowing = (): void => {
      this.isFollowing = false;
    };
    this.map.on("mousedown", stopFollowing);
    this.map.on("touchstart", stopFollowing);
    this.map.on("movestart", ({ originalEvent }) => originalEvent !== undefined && stopFollowing());
    this.map.on("resize", () => this.follow());
    this.map.once("load", () => {
      this.isLoaded = true;
      this.endGathering = gatherDrawings(this.map);
      this.draw();
      this.follow();
    });
  }

  /** Camera position that an operator has chosen, or null. */
  get camera(): Camera | null {
    if (this.isFollowing) return null;
    const { lng, lat } = this.map.getCenter();
    return { center: [lng, lat], zoom: this.map.getZoom() };
  }

  remove(): void {
    this.endCoarseDrawing();
    this.endGathering();
    this.map.remove();
  }

  /** Show these layers, bottom up, with the scene. */
  update(layers: readonly MapLayer[], scene: Scene, theme: Theme): void {
    const isSame = layers.length === this.layers.length && layers.every((layer, i) => layer === this.layers[i]);
    if (!isSame) this.detachAll();
    this.layers = layers;
    this.scene = scene;
    if (theme !== this.theme) this.changeTheme(theme);
    else this.draw();
    const located = scene.mission.vehicles.filter(({ position }) => position !== null).length;
    if (located !== this.located) this.follow();
    this.located = located;
  }

  /** Show all vehicles, their waypoints, the search area, the geofence, and more places. */
  fitFleet(more: readonly EnuPoint[] = []): void {
    if (this.scene === null) return;
    const { mission, origin } = this.scene;
    const bounds = boundsOf([...fleetPoints(mission), ...more], FIT_MARGIN_M);
    if (bounds === null) return;
    const southWest = toLngLat(origin, [bounds.west_m, bounds.south_m]);
    const northEast = toLngLat(origin, [bounds.east_m, bounds.north_m]);
    this.map.fitBounds([southWest, northEast], { padding: 36, animate: false, maxZoom: 20 });
  }

  /** Show one place at close range. */
  lookAt(place: EnuPoint): void {
    if (this.scene === null) return;
    this.isFollowing = false;
    const zoom = Math.max(this.map.getZoom(), NEAR_ZOOM);
    this.map.jumpTo({ center: toLngLat(this.scene.origin, place), zoom });
  }

  private follow(): void {
    if (this.isLoaded && this.isFollowing) this.fitFleet();
  }

  private draw(): void {
    if (!this.isLoaded || this.scene === null) return;
    for (const layer of this.layers) {
      if (!this.attached.has(layer.id)) this.attached.set(layer.id, layer.attach(this.map, PALETTES[this.theme]));
      this.attached.get(layer.id)?.update(this.scene);
    }
  }

  private detachAll(): void {
    for (const layer of this.attached.values()) layer.remove();
    this.attached.clear();
  }

  /** Load the style of another theme; drawing continues once it is loaded. */
  private changeTheme(theme: Theme): void {
    this.theme = theme;
    this.detachAll();
    this.isLoaded = false;
    this.map.getContainer().style.background = PALETTES[theme].background;
    this.map.setStyle(EMPTY_STYLE, { diff: false });
    this.map.once("style.load", () => {
      this.isLoaded = true;
      this.draw();
    });
  }
}

/** No background layer: the container has the colour, and a layer would take an eighth of the time of a frame. */
const EMPTY_STYLE: StyleSpecification = { version: 8, sources: {}, layers: [] };

/** Points that "Fit to fleet" shows. */
function fleetPoints(mission: Mission): EnuPoint[] {
  const moving = mission.vehicles.flatMap(({ position, waypoint }) => [position, waypoint]);
  return [
    ...moving.filter((place): place is Position => place !== null).map(enu),
    ...mission.area.map(enu),
    ...mission.fence.map(enu),
  ];
}
