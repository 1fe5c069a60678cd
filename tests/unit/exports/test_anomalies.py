"""Maps as GeoTIFF and findings as tables: read back by others, at the right place."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pymap3d
import pytest
import rasterio
from numpy.typing import NDArray
from rasterio.warp import transform

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.anomaly_table import encode_anomalies
from aos_gcs.exports.georeference import LocalGeoreference, ProjectedGeoreference
from aos_gcs.exports.geotiff import write_geotiff
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.model import MapRaster
from aos_gcs.surveys.anomalies import MapBlob

ORIGINS = [
    GeodeticPosition(48.3069, 14.2858, 310.0),
    GeodeticPosition(-33.86, 151.2, 5.0),
    GeodeticPosition(27.99, 86.93, 4900.0),
    GeodeticPosition(69.6, -18.9, -20.0),
    GeodeticPosition(0.01, 179.995, 50.0),
]


def written(path: Path, values: NDArray[np.float32], raster: MapRaster, crs: str) -> Path:
    write_geotiff(path, values, raster, crs, descriptions=("red", "green", "blue"), nodata=np.nan)
    return path


@pytest.mark.parametrize("origin", ORIGINS)
def test_pixels_lie_where_they_are_on_the_earth(tmp_path: Path, origin: GeodeticPosition) -> None:
    height_m = 12.0
    raster = MapRaster(x_m=-2000.0, y_m=1500.0, resolution_m=10.0, rows=300, columns=400, rows_along_y=False)
    values = np.zeros((300, 400, 3), dtype=np.float32)
    path = written(tmp_path / "map.tif", values, raster, LocalGeoreference(origin).crs(height_m))
    with rasterio.open(path) as dataset:
        for row, column in ((0, 0), (0, 399), (150, 200), (299, 0), (299, 399)):
            x, y = dataset.xy(row, column)
            (longitude,), (latitude,) = transform(dataset.crs, "EPSG:4326", [x], [y])
            x_m, y_m, _ = raster.to_plane @ (column, row, 1.0)
            at = (origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m)
            expected = pymap3d.enu2geodetic(x_m, y_m, height_m, *at)
            east_m, north_m, _ = pymap3d.geodetic2enu(latitude, longitude, expected[2], *at)
            assert np.hypot(east_m - x_m, north_m - y_m) < 0.05


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    values = rng.uniform(0, 255, (700, 600, 3)).astype(np.float32)
    values[:100] = np.nan
    raster = MapRaster(10.0, 20.0, 0.25, 700, 600, rows_along_y=False)
    path = written(tmp_path / "map.tif", values, raster, LocalGeoreference(ORIGINS[0]).crs(0.0))
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.tif"]
    with rasterio.open(path) as dataset:
        np.testing.assert_array_equal(np.moveaxis(dataset.read(), 0, 2), values)
        assert np.isnan(dataset.nodata)
        assert dataset.descriptions == ("red", "green", "blue")
        assert dataset.profile["tiled"]
        assert dataset.profile["compress"] == "deflate"
        assert dataset.tags(ns="IMAGE_STRUCTURE")["LAYOUT"] == "COG"
        assert dataset.overviews(1)
        assert tuple(dataset.transform)[:6] == (0.25, 0.0, 10.0, 0.0, -0.25, 20.0)


def test_counts_are_written_as_counts(tmp_path: Path) -> None:
    counts = np.arange(12, dtype=np.uint16).reshape(3, 4, 1)
    raster = MapRaster(500_000.0, 5_350_000.0, 1.0, 3, 4, rows_along_y=False)
    write_geotiff(tmp_path / "count.tif", counts, raster, "EPSG:32633", descriptions=("images",), nodata=0)
    with rasterio.open(tmp_path / "count.tif") as dataset:
        assert dataset.crs.to_epsg() == 32633
        assert dataset.dtypes == ("uint16",)
        np.testing.assert_array_equal(dataset.read(1), counts[:, :, 0])


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    raster = MapRaster(0.0, 0.0, 1.0, 3, 4, rows_along_y=False)
    values = np.zeros((3, 4, 3), dtype=np.float32)
    with pytest.raises(ConfigurationError, match=r"Cannot write .*map\.tif"):
        written(tmp_path / "absent" / "map.tif", values, raster, "EPSG:32633")
    with pytest.raises(ConfigurationError, match=r"Cannot write .*map\.tif"):
        written(tmp_path / "map.tif", values, raster, "+proj=nonsense")
    assert not list(tmp_path.iterdir())


def test_a_projected_world_keeps_its_system() -> None:
    with rasterio.Env():
        wkt = rasterio.CRS.from_epsg(32633).to_wkt()
    place = ProjectedGeoreference(wkt)
    assert place.crs(100.0) == wkt
    # On the central meridian of zone 33 the easting is half a million metres.
    latitude_deg, longitude_deg = place.latitude_longitude_deg(500_000.0, 5_350_000.0, 0.0)
    assert longitude_deg == pytest.approx(15.0, abs=1e-9)
    assert latitude_deg == pytest.approx(48.3, abs=0.1)


BLOBS = [MapBlob((10.0, -20.0, 1.0), 1.25, 7, 0.5), MapBlob((0.0, 0.0, 1.0), 0.5, 3, 0.25)]


def test_geojson_has_longitude_first() -> None:
    document = json.loads(encode_anomalies(BLOBS, LocalGeoreference(ORIGINS[0]), ".geojson"))
    first, second = document["features"]
    assert second["geometry"]["coordinates"] == pytest.approx([14.2858, 48.3069])
    assert first["geometry"]["coordinates"][0] > 14.2858
    assert first["geometry"]["coordinates"][1] < 48.3069
    assert first["properties"]["area_m2"] == 1.25
    assert first["id"] == 1


def test_tables_without_a_place_on_the_earth() -> None:
    rows = list(csv.DictReader(io.StringIO(encode_anomalies(BLOBS, None, ".csv"))))
    assert [row["x_m"] for row in rows] == ["10.0", "0.0"]
    assert rows[0]["latitude_deg"] == ""
    anomalies = json.loads(encode_anomalies(BLOBS, None, ".json"))["anomalies"]
    assert anomalies[1]["max_count"] == 3
    assert anomalies[1]["latitude_deg"] is None
    with pytest.raises(ConfigurationError, match="the place of the map is not known"):
        encode_anomalies(BLOBS, None, ".geojson")
    with pytest.raises(ConfigurationError, match=r"\.geojson, \.json, \.csv, not as '\.xls'"):
        encode_anomalies(BLOBS, None, ".xls")
