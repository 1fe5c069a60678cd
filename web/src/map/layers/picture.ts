/** Latest image of the selected kind, at its true position on the ground. */
import type { ImageSource, Map as MapLibreMap } from "maplibre-gl";
import type { Picture, Vertex } from "../../api/types";
import type { LngLat } from "../../geometry";
import type { AttachedLayer, MapLayer, Scene } from "../layer";

const PICTURE = "picture";
/** Invisible layer that reserves the place of the image among the layers until there is one. */
const SLOT = "picture-slot";

type Corners = [LngLat, LngLat, LngLat, LngLat];

export const pictureLayer: MapLayer = {
  id: PICTURE,
  attach(map) {
    map.addLayer({ id: SLOT, type: "background", layout: { visibility: "none" } });
    return new AttachedPicture(map);
  },
};

class AttachedPicture implements AttachedLayer {
  private url = "";
  private isVisible = false;
  private opacity = NaN;

  constructor(private readonly map: MapLibreMap) {}

  update({ state, overlay }: Scene): void {
    const picture = overlay === null ? undefined : state.pictures[overlay.kind];
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
    if (this.map.getLayer(PICTURE)) this.map.removeLayer(PICTURE);
    if (this.map.getSource(PICTURE)) this.map.removeSource(PICTURE);
    this.map.removeLayer(SLOT);
  }

  /** MapLibre draws the map anew whenever a property is set, also to the value that it has. */
  private setVisible(isVisible: boolean): void {
    if (isVisible === this.isVisible) return;
    this.isVisible = isVisible;
    this.map.setLayoutProperty(PICTURE, "visibility", isVisible ? "visible" : "none");
  }

  private setOpacity(opacity: number): void {
    if (opacity === this.opacity) return;
    this.opacity = opacity;
    this.map.setPaintProperty(PICTURE, "raster-opacity", opacity);
  }

  private show(picture: Picture, coordinates: Corners): void {
    if (picture.url === this.url) return;
    this.url = picture.url;
    const source = this.map.getSource<ImageSource>(PICTURE);
    if (source) {
      source.updateImage({ url: picture.url, coordinates });
      return;
    }
    this.map.addSource(PICTURE, { type: "image", url: picture.url, coordinates });
    this.map.addLayer({ id: PICTURE, type: "raster", source: PICTURE, paint: { "raster-fade-duration": 0 } }, SLOT);
  }
}

/** Corners as MapLibre wants them; null unless all four are known. */
export function cornersOf(corners: readonly Vertex[]): Corners | null {
  const places = corners.flatMap(({ latitude_deg: lat, longitude_deg: lng }): LngLat[] =>
    lat === null || lng === null ? [] : [[lng, lat]],
  );
  return places.length === 4 ? (places as Corners) : null;
}
