/**
 * Base map from a PMTiles file of the station or of this computer: raster images, or vectors in the layers of Protomaps or
 * OpenMapTiles.
 */
import maplibregl, { type LayerSpecification } from "maplibre-gl";
import { FileSource, type Header, PMTiles, Protocol, TileType } from "pmtiles";
import type { MapLayer } from "../layer";
import { groundParts } from "./ground";

const SOURCE = "basemap";

const protocol = new Protocol();
maplibregl.addProtocol("pmtiles", protocol.tile);
/** Number of files of this computer that were opened. */
let count = 0;

/** Read the header of a file of the station and make a layer of it; rejects for files that cannot be shown. */
export const openBasemap = (url: string): Promise<MapLayer> =>
  basemapLayer(new PMTiles(new URL(url, location.href).href));

/** Make a layer of a file of this computer; rejects for one that cannot be shown. */
export async function openBasemapFile(file: File): Promise<MapLayer> {
  const archive = new PMTiles(new NumberedFile(file, ++count));
  const problem = problemOf(await archive.getHeader(), file.size);
  if (problem !== null) throw new Error(problem);
  return basemapLayer(archive);
}

/** Layer of an archive; rejects for one that cannot be shown. */
async function basemapLayer(archive: PMTiles): Promise<MapLayer> {
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

/** Reason why an archive cannot be shown, for the log; null if it can. */
function problemOf(header: Header, size: number): string | null {
  const ends = [
    header.rootDirectoryOffset + header.rootDirectoryLength,
    header.jsonMetadataOffset + header.jsonMetadataLength,
    (header.leafDirectoryOffset ?? 0) + (header.leafDirectoryLength ?? 0),
    (header.tileDataOffset ?? 0) + (header.tileDataLength ?? 0),
  ];
  if (header.specVersion !== VERSION) return `version ${header.specVersion}`;
  if (header.tileType === TileType.Unknown) return "unknown kind of tiles";
  if (![header.internalCompression, header.tileCompression].every((code) => READABLE.includes(code))) {
    return "compression that browsers do not read";
  }
  return ends.some((end) => end > size) ? "incomplete" : null;
}

const VERSION = 3;
/** Numbers of PMTiles for no compression and gzip. */
const READABLE: readonly number[] = [1, 2];

/** File with a key of its own: two files of one name are two maps. */
class NumberedFile extends FileSource {
  constructor(
    file: File,
    private readonly number: number,
  ) {
    super(file);
  }

  override getKey(): string {
    return `file-${this.number}`;
  }
}
