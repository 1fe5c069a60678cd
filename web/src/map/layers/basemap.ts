/**
 * Base map from a PMTiles file of the station: raster images, or vectors in the layers of Protomaps or OpenMapTiles.
 */
import maplibregl, { type LayerSpecification } from "maplibre-gl";
import { PMTiles, Protocol, TileType } from "pmtiles";
import type { MapLayer } from "../layer";
import { groundParts } from "./ground";

const SOURCE = "basemap";

const protocol = new Protocol();
maplibregl.addProtocol("pmtiles", protocol.tile);

/** Read the header of a file of the station and make a layer of it; rejects for files that cannot be shown. */
export const openBasemap = (url: string): Promise<MapLayer> =>
  basemapLayer(new PMTiles(new URL(url, location.href).href));

/** Layer of an archive; rejects for one that cannot be shown. */
export async function basemapLayer(archive: PMTiles): Promise<MapLayer> {
  protocol.add(archive);
  const { tileType, maxZoom } = await archive.getHeader();
  const attribution = attributionOf(await archive.getMetadata());
  const isVector = tileType === TileType.Mvt;
  return {
    id: SOURCE,
    ...(attribution === "" ? {} : { attribution }),
    attach(map, palette) {
      map.addSource(SOURCE, {
        type: isVector ? "vector" : "raster",
        url: `pmtiles://${archive.source.getKey()}`,
        maxzoom: maxZoom,
        ...(isVector ? {} : { tileSize: 256 }),
      });
      const ids = (isVector ? groundParts(palette) : [{ type: "raster" as const }]).map((part, index) => {
        const id = `${SOURCE}-${index}`;
        map.addLayer({ ...part, id, source: SOURCE } as LayerSpecification);
        return id;
      });
      return {
        update: () => undefined, // the ground does not change
        remove() {
          for (const id of ids) map.removeLayer(id);
          map.removeSource(SOURCE);
        },
      };
    },
  };
}

const LONGEST_ATTRIBUTION = 200;

/** Attribution of an archive as plain text: in files it may be HTML, which is not shown as such. */
function attributionOf(metadata: unknown): string {
  const said =
    typeof metadata === "object" && metadata !== null && "attribution" in metadata ? metadata.attribution : "";
  const page = new DOMParser().parseFromString(typeof said === "string" ? said : "", "text/html");
  return (page.body.textContent ?? "").trim().slice(0, LONGEST_ATTRIBUTION);
}
