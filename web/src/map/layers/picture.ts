/** Images at their true position on the ground: the latest of the selected kind, and what has been searched. */
import type { ImageSource, Map as MapLibreMap } from "maplibre-gl";
import type { Picture, Vertex } from "../../api/types";
import type { LngLat } from "../../geometry";
import { searchedKind } from "../../state/searched";
import type { AttachedLayer, MapLayer, Overlay, Scene } from "../layer";

type Corners = [LngLat, LngLat, LngLat, LngLat];

/** Time after which an image that has not arrived is replaced by a newer one. */
const PATIENCE_MS = 20_000;

export const pictureLayer: MapLayer = imageLayer("picture", ({ overlay }) => overlay);

/** Probability of detection, or the views of each place until the forest is described; below the selected image. */
export const searchedLayer: MapLayer = imageLayer("searched", ({ state }) => {
  const kind = searchedKind(state.pictures);
  return kind === null ? null : { kind, opacity: 1 };
});

function imageLayer(id: string, choose: (scene: Scene) => Overlay | null): MapLayer {
  return {
    id,
    attach(map) {
      // An invisible layer reserves the place of the image among the layers until there is one.
      map.addLayer({ id: slotOf(id), type: "background", layout: { visibility: "none" } });
      return new AttachedImage(map, id, choose);
    },
  };
}

const slotOf = (id: string): string => `${id}-slot`;

class AttachedImage implements AttachedLayer {
  private url = "";
  private askedAtMs = 0;
  private isVisible = false;
  private opacity = NaN;

  constructor(
    private readonly map: MapLibreMap,
    private readonly id: string,
    private readonly choose: (scene: Scene) => Overlay | null,
  ) {}

  update(scene: Scene): void {
    const overlay = this.choose(scene);
    const picture = overlay === null ? undefined : scene.state.pictures[overlay.kind];
    const corners = picture && cornersOf(picture.corners);
    if (overlay === null || picture === undefined || !corners) {
      this.setVisible(false);
      return;
    }
    this.show(picture, corners);
    this.setVisible(true);
    this.setOpacity(overlay.opacity);
  }

  remove(): void {
    if (this.map.getLayer(this.id)) this.map.removeLayer(this.id);
    if (this.map.getSource(this.id)) this.map.removeSource(this.id);
    this.map.removeLayer(slotOf(this.id));
  }

  /** MapLibre draws the map anew whenever a property is set, also to the value that it has. */
  private setVisible(isVisible: boolean): void {
    if (isVisible === this.isVisible) return;
    this.isVisible = isVisible;
    this.map.setLayoutProperty(this.id, "visibility", isVisible ? "visible" : "none");
  }

  private setOpacity(opacity: number): void {
    if (opacity === this.opacity) return;
    this.opacity = opacity;
    this.map.setPaintProperty(this.id, "raster-opacity", opacity);
  }

  private show(picture: Picture, coordinates: Corners): void {
    if (picture.url === this.url) return;
    const { id } = this;
    const source = this.map.getSource<ImageSource>(id);
    // A new image ends the loading of the one before: where each step is faster than the link, none would ever be shown.
    if (source?.loaded() === false && performance.now() - this.askedAtMs < PATIENCE_MS) return;
    this.url = picture.url;
    this.askedAtMs = performance.now();
    if (source) {
      source.updateImage({ url: picture.url, coordinates });
      return;
    }
    this.map.addSource(id, { type: "image", url: picture.url, coordinates });
    this.map.addLayer({ id, type: "raster", source: id, paint: { "raster-fade-duration": 0 } }, slotOf(id));
  }
}

/** Corners as MapLibre wants them; null unless all four are known. */
export function cornersOf(corners: readonly Vertex[]): Corners | null {
  const places = corners.flatMap(({ latitude_deg: lat, longitude_deg: lng }): LngLat[] =>
    lat === null || lng === null ? [] : [[lng, lat]],
  );
  return places.length === 4 ? (places as Corners) : null;
}
