/** A base map from a PMTiles file of the service: pictures, or vectors in the layers of the Protomaps basemap. */
import maplibregl, { type LayerSpecification } from "maplibre-gl";
import { PMTiles, Protocol, TileType } from "pmtiles";
import type { MapLayer } from "../layer";
import type { Palette } from "../palette";

const SOURCE = "basemap";
/** Of a layer of the Protomaps basemap, without its id and source. */
type Part = Omit<Extract<LayerSpecification, { "source-layer"?: string }>, "id" | "source">;

const protocol = new Protocol();
maplibregl.addProtocol("pmtiles", protocol.tile);

/** Read the file's header and make a layer of it; rejects when the file is none that can be shown. */
export async function openBasemap(url: string): Promise<MapLayer> {
  const absolute = new URL(url, location.href).href;
  const archive = new PMTiles(absolute);
  protocol.add(archive);
  const { tileType, maxZoom } = await archive.getHeader();
  const isVector = tileType === TileType.Mvt;
  return {
    id: SOURCE,
    attach(map, palette) {
      map.addSource(SOURCE, {
        type: isVector ? "vector" : "raster",
        url: `pmtiles://${absolute}`,
        maxzoom: maxZoom,
        ...(isVector ? {} : { tileSize: 256 }),
      });
      const ids = (isVector ? vectorParts(palette) : [{ type: "raster" as const }]).map((part, index) => {
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

/** Quiet colours: what flies has to stand out. */
function vectorParts({ ground, label, halo }: Palette): Part[] {
  const fill = (layer: string, colour: string, kinds?: readonly string[]): Part => ({
    type: "fill",
    "source-layer": layer,
    ...(kinds === undefined ? {} : { filter: ["in", ["get", "kind"], ["literal", kinds]] }),
    paint: { "fill-color": colour },
  });
  return [
    fill("earth", ground.earth),
    fill("landuse", ground.wood, ["wood", "forest", "park", "nature_reserve", "national_park"]),
    fill("landcover", ground.wood, ["forest"]),
    fill("water", ground.water),
    fill("buildings", ground.building),
    {
      type: "line",
      "source-layer": "roads",
      paint: {
        "line-color": ground.road,
        "line-width": ["match", ["get", "kind"], "highway", 4, "major_road", 3, "minor_road", 2, 1],
      },
    },
    {
      type: "symbol",
      "source-layer": "places",
      layout: { "text-field": ["get", "name"], "text-size": 12 },
      paint: { "text-color": label, "text-halo-color": halo, "text-halo-width": 1.5, "text-opacity": 0.8 },
    },
  ];
}
