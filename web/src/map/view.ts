/** The MapLibre map and what it shows at present. Redraws only when something has changed. */
import maplibregl, { type GeoJSONSource, type ImageSource, type Map as MapLibreMap } from "maplibre-gl";
import type { Geodetic, Mission, Picture, PictureKind, Vertex } from "../api/types";
import { boundsOf, type LngLat, toEnu, toLngLat } from "../geometry";
import type { EnuPoint, State } from "../state/state";
import { fixedFeatures, fixedKey, fleetPoints, movingFeatures } from "./features";
import { ABOVE_PICTURE, FIXED_SOURCE, makeStyle, MOVING_SOURCE } from "./layers";
import { Markers } from "./markers";
import type { Theme } from "./palette";

export interface MapOptions {
  theme: Theme;
  layer: PictureKind | null;
  opacity: number;
  selected: ReadonlySet<number>;
}

export interface MapEvents {
  onSelect(vehicleId: number): void;
  onCursor(place: { enu: EnuPoint; lngLat: LngLat } | null): void;
}

const PICTURE = "picture";
const FIT_MARGIN_M = 8;
type Corners = [LngLat, LngLat, LngLat, LngLat];

/** Whether the browser can draw the map. */
export function hasWebGl(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

export class MapView {
  private readonly map: MapLibreMap;
  private readonly markers: Markers;
  private isLoaded = false;
  private theme: Theme;
  private shown: { fixed: string; picture: string } = { fixed: "", picture: "" };
  private latest: { mission: Mission; state: State; options: MapOptions } | null = null;

  constructor(container: HTMLElement, origin: Geodetic, theme: Theme, events: MapEvents) {
    maplibregl.setWorkerCount(1);
    this.theme = theme;
    this.map = new maplibregl.Map({
      container,
      style: makeStyle(theme),
      center: toLngLat(origin, [0, 0]),
      zoom: 17,
      maxZoom: 22,
      attributionControl: false,
      dragRotate: false,
      pitchWithRotate: false,
      touchPitch: false,
      renderWorldCopies: false,
      fadeDuration: 0,
    });
    this.map.touchZoomRotate.disableRotation();
    this.map.addControl(new maplibregl.ScaleControl({ unit: "metric", maxWidth: 140 }), "bottom-left");
    this.map.addControl(new maplibregl.NavigationControl({ showCompass: false }), "top-right");
    this.markers = new Markers(this.map, events.onSelect);
    this.map.on("mousemove", ({ lngLat }) => {
      const place: LngLat = [lngLat.lng, lngLat.lat];
      events.onCursor({ lngLat: place, enu: toEnu(this.latest?.mission.origin ?? origin, place) });
    });
    this.map.on("mouseout", () => events.onCursor(null));
    this.map.once("load", () => {
      this.isLoaded = true;
      this.draw();
      this.fitFleet();
    });
  }

  remove(): void {
    this.map.remove();
  }

  update(mission: Mission, state: State, options: MapOptions): void {
    this.latest = { mission, state, options };
    this.draw();
  }

  /** Show all vehicles, their waypoints and the search area. */
  fitFleet(): void {
    const mission = this.latest?.mission;
    const bounds = mission ? boundsOf(fleetPoints(mission), FIT_MARGIN_M) : null;
    if (!mission?.origin || bounds === null) return;
    const southWest = toLngLat(mission.origin, [bounds.west_m, bounds.south_m]);
    const northEast = toLngLat(mission.origin, [bounds.east_m, bounds.north_m]);
    this.map.fitBounds([southWest, northEast], { padding: 36, animate: false, maxZoom: 20 });
  }

  private draw(): void {
    const { latest } = this;
    const origin = latest?.mission.origin;
    if (!latest || !origin || !this.isLoaded) return;
    const { mission, state, options } = latest;
    if (options.theme !== this.theme) {
      this.changeTheme(options.theme);
      return;
    }
    const key = fixedKey(mission);
    if (key !== this.shown.fixed) {
      this.shown.fixed = key;
      this.source(FIXED_SOURCE).setData(fixedFeatures(origin, mission));
    }
    this.source(MOVING_SOURCE).setData(movingFeatures(origin, mission, state));
    this.drawPicture(options.layer === null ? undefined : state.pictures[options.layer], options.opacity);
    this.markers.update(origin, mission, options.selected, (performance.now() - state.missionAtMs) / 1000);
  }

  /** Load the other style; drawing goes on when it is there. */
  private changeTheme(theme: Theme): void {
    this.theme = theme;
    this.shown = { fixed: "", picture: "" };
    this.map.setStyle(makeStyle(theme), { diff: false });
    this.isLoaded = false;
    this.map.once("style.load", () => {
      this.isLoaded = true;
      this.draw();
    });
  }

  private drawPicture(picture: Picture | undefined, opacity: number): void {
    const corners = picture && toCorners(picture.corners);
    if (!picture || !corners) {
      if (this.map.getLayer(PICTURE)) this.map.setLayoutProperty(PICTURE, "visibility", "none");
      return;
    }
    const known = this.map.getSource<ImageSource>(PICTURE);
    if (!known) {
      this.map.addSource(PICTURE, { type: "image", url: picture.url, coordinates: corners });
      const paint = { "raster-opacity": opacity, "raster-fade-duration": 0 };
      this.map.addLayer({ id: PICTURE, type: "raster", source: PICTURE, paint }, ABOVE_PICTURE);
    } else if (picture.url !== this.shown.picture) {
      known.updateImage({ url: picture.url, coordinates: corners });
    }
    this.shown.picture = picture.url;
    this.map.setLayoutProperty(PICTURE, "visibility", "visible");
    this.map.setPaintProperty(PICTURE, "raster-opacity", opacity);
  }

  private source(id: string): GeoJSONSource {
    const source = this.map.getSource<GeoJSONSource>(id);
    if (!source) throw new Error(`the map's style has no source '${id}'`);
    return source;
  }
}

function toCorners(corners: readonly Vertex[]): Corners | null {
  const places = corners.flatMap(({ latitude_deg: lat, longitude_deg: lng }): LngLat[] =>
    lat === null || lng === null ? [] : [[lng, lat]],
  );
  return places.length === 4 ? (places as Corners) : null;
}
