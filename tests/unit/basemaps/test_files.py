"""Base maps of the files that teams have: every pixel where it belongs, and what cannot be used named."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rasterio")
pytest.importorskip("pmtiles")

from aos_gcs.api.basemap_file import check_basemap
from aos_gcs.basemaps import pyramid as pyramid_module
from aos_gcs.basemaps.making import BasemapReport, make_basemap
from aos_gcs.errors import ConfigurationError, InputDataError
from tests.fakes.command_line import exit_status
from tests.fakes.map_files import (
    BLUE,
    GREEN,
    QUARTERS,
    RED,
    WHITE,
    ShownMap,
    png,
    quarters,
    write_kmz,
    write_mbtiles,
    write_raster,
)


@contextmanager
def silent(_total: int) -> Iterator[pyramid_module.Advance]:
    yield lambda _: None


def made(out: Path, *files: Path, max_zoom: int | None = None) -> BasemapReport:
    report = make_basemap(out, files, silent, max_zoom)
    check_basemap(out)
    return report


def assert_quarters(shown: ShownMap, distance_m: float = 20.0, zoom: int | None = None) -> None:
    for (east, north), colour in QUARTERS.items():
        *seen, opacity = shown.colour(east * distance_m, north * distance_m, zoom)
        assert seen == pytest.approx(colour, abs=12)
        assert opacity == 255


@pytest.mark.parametrize(("crs", "cell_m"), [("EPSG:32633", 0.5), ("EPSG:31255", 0.5), ("EPSG:3857", 0.74)])
def test_an_orthophoto_lies_where_it_belongs_at_every_zoom(tmp_path: Path, crs: str, cell_m: float) -> None:
    file = write_raster(tmp_path / "ortho.tif", quarters(), crs=crs, cell_m=cell_m)
    report = made(tmp_path / "map.pmtiles", file)
    shown = ShownMap(tmp_path / "map.pmtiles")
    assert report.max_zoom == shown.header["max_zoom"] == 18
    assert shown.header["min_zoom"] == report.min_zoom == 15
    for zoom in range(16, 19):
        assert_quarters(shown, 15.0, zoom)
    # The edges between the quarters are within a pixel, which is 0.4 m wide.
    assert shown.colour(-0.8, 10.0)[0] > 180
    assert shown.colour(0.8, 10.0)[0] < 80
    assert shown.colour(65.0, 0.0)[3] == 0
    west, south = shown.header["min_lon_e7"] / 1e7, shown.header["min_lat_e7"] / 1e7
    assert (west, south) == pytest.approx((14.25 - 50.0 / 75_300.0, 47.5 - 50.0 / 111_180.0), abs=1e-4)


def test_nodata_opacity_grey_and_colour_tables_are_understood(tmp_path: Path) -> None:
    holed = quarters()
    holed[:100, :100] = 0
    opaque = np.full((200, 200, 1), 255, dtype=np.uint8)
    opaque[:100, :100] = 0
    numbers = np.zeros((200, 200, 1), dtype=np.uint8)
    numbers[:, 100:] = 7
    files = {
        "nodata": write_raster(tmp_path / "nodata.tif", holed, nodata=0),
        "alpha": write_raster(tmp_path / "alpha.tif", np.dstack((quarters(), opaque)), photometric="RGB", alpha="YES"),
        "grey": write_raster(tmp_path / "grey.tif", quarters()[..., :1]),
        "table": write_raster(tmp_path / "table.tif", numbers, colormap={0: (*BLUE, 255), 7: (*GREEN, 255)}),
    }
    shown = {}
    for name, file in files.items():
        made(tmp_path / f"{name}.pmtiles", file)
        shown[name] = ShownMap(tmp_path / f"{name}.pmtiles")
    for name in ("nodata", "alpha"):
        assert shown[name].colour(-20.0, 20.0)[3] == 0
        assert shown[name].colour(20.0, 20.0)[:3] == pytest.approx(GREEN, abs=12)
    assert shown["grey"].colour(-20.0, 20.0) == pytest.approx((RED[0],) * 3 + (255,), abs=12)
    assert shown["table"].colour(-20.0, 0.0)[:3] == pytest.approx(BLUE, abs=12)
    assert shown["table"].colour(20.0, 0.0)[:3] == pytest.approx(GREEN, abs=12)


def test_later_files_lie_on_top_and_the_rest_shows_through(tmp_path: Path) -> None:
    below = write_raster(tmp_path / "below.tif", quarters())
    small = np.full((40, 40, 3), 10, dtype=np.uint8)
    above = write_raster(tmp_path / "above.tif", small, tags={"TIFFTAG_COPYRIGHT": "Survey of Styria"})
    made(tmp_path / "map.pmtiles", below, above)
    shown = ShownMap(tmp_path / "map.pmtiles")
    assert shown.colour(-5.0, 5.0)[:3] == pytest.approx((10, 10, 10), abs=12)
    assert_quarters(shown)
    assert shown.metadata["attribution"] == "Survey of Styria"


def test_all_rasters_of_a_geopackage_are_shown(tmp_path: Path) -> None:
    file = tmp_path / "maps.gpkg"
    write_raster(file, quarters(), driver="GPKG", RASTER_TABLE="ortho")
    made(tmp_path / "one.pmtiles", file)
    assert_quarters(ShownMap(tmp_path / "one.pmtiles"), 15.0)
    small = np.full((40, 40, 3), 10, dtype=np.uint8)
    write_raster(file, small, driver="GPKG", RASTER_TABLE="small", APPEND_SUBDATASET="YES")
    made(tmp_path / "two.pmtiles", file)
    assert ShownMap(tmp_path / "two.pmtiles").colour(-5.0, 5.0)[:3] == pytest.approx((10, 10, 10), abs=12)


def test_ground_overlays_are_turned_counter_clockwise_about_their_middle(tmp_path: Path) -> None:
    made(tmp_path / "map.pmtiles", write_kmz(tmp_path / "map.kmz", {"map.png": png(quarters(400))}))
    assert_quarters(ShownMap(tmp_path / "map.pmtiles"))
    turned = write_kmz(tmp_path / "turned.kmz", {"map.png": png(quarters(400))}, rotation_deg=90.0)
    made(tmp_path / "turned.pmtiles", turned)
    shown = ShownMap(tmp_path / "turned.pmtiles")
    for place, colour in {(-20.0, -20.0): RED, (-20.0, 20.0): GREEN, (20.0, -20.0): BLUE, (20.0, 20.0): WHITE}.items():
        assert shown.colour(*place)[:3] == pytest.approx(colour, abs=12)


def test_a_transparent_picture_lends_no_dark_rim_to_coarse_tiles(tmp_path: Path) -> None:
    picture = np.dstack((quarters(400), np.full((400, 400), 255, dtype=np.uint8)))
    picture[:, :200] = 0
    made(tmp_path / "map.pmtiles", write_kmz(tmp_path / "map.kmz", {"map.png": png(picture)}))
    shown = ShownMap(tmp_path / "map.pmtiles")
    for zoom in range(shown.header["min_zoom"] + 1, shown.header["max_zoom"] + 1):
        for east_m in np.linspace(-4.0, 4.0, 9):
            *colour, opacity = shown.colour(east_m, 20.0, zoom)
            if opacity > 40:
                assert colour == pytest.approx(GREEN, abs=30)


def test_the_tiles_of_an_mbtiles_file_are_copied_as_they_are(tmp_path: Path) -> None:
    tiles = {(2, 1, 3): b"north", (2, 3, 0): b"south-east", (0, 0, 0): b"world"}
    file = write_mbtiles(tmp_path / "m.mbtiles", tiles, {"format": "jpg", "attribution": "A team"})
    assert made(tmp_path / "map.pmtiles", file).tiles == 3
    shown = ShownMap(tmp_path / "map.pmtiles")
    assert (shown.tile(2, 1, 0), shown.tile(2, 3, 3), shown.tile(0, 0, 0)) == (b"north", b"south-east", b"world")
    assert shown.header["tile_type"].name == "JPEG"
    assert (shown.header["min_lon_e7"], shown.header["max_lon_e7"]) == (-90 * 10**7, 180 * 10**7)
    assert shown.metadata["attribution"] == "A team"


def test_vectors_keep_their_compression_and_layers(tmp_path: Path) -> None:
    metadata = {"format": "pbf", "bounds": "14,47,15,48", "json": '{"vector_layers": [{"id": "roads"}]}'}
    file = write_mbtiles(tmp_path / "v.mbtiles", {(0, 0, 0): gzip.compress(b"tile")}, metadata)
    made(tmp_path / "map.pmtiles", file)
    shown = ShownMap(tmp_path / "map.pmtiles")
    assert shown.header["tile_compression"].name == "GZIP"
    assert shown.header["min_lat_e7"] == pytest.approx(47e7, abs=2)
    assert shown.metadata["vector_layers"] == [{"id": "roads"}]


def test_a_smaller_zoom_makes_a_smaller_map(tmp_path: Path) -> None:
    file = write_raster(tmp_path / "ortho.tif", quarters())
    whole = made(tmp_path / "whole.pmtiles", file)
    coarse = made(tmp_path / "coarse.pmtiles", file, max_zoom=16)
    assert coarse.max_zoom == 16
    assert coarse.tiles < whole.tiles
    assert_quarters(ShownMap(tmp_path / "coarse.pmtiles"))


def test_the_command_says_what_it_has_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = write_raster(tmp_path / "ortho.tif", quarters()), tmp_path / "map.pmtiles"
    assert exit_status(["basemap", str(out), str(file), "--max-zoom", "17"]) == 0
    assert re.fullmatch(rf"{out}: \d+ tiles, zooms 15 to 17, 0\.0 MB\n", capsys.readouterr().out)
    assert exit_status(["basemap", str(out), str(tmp_path / "gone.tif")]) == 2
    assert "gone.tif" in capsys.readouterr().err


def test_progress_counts_every_tile_once(tmp_path: Path) -> None:
    file = write_raster(tmp_path / "ortho.tif", quarters(), cell_m=0.2)
    steps: list[int] = []

    @contextmanager
    def counted(total: int) -> Iterator[pyramid_module.Advance]:
        yield steps.append
        assert sum(steps) == total > 1

    make_basemap(tmp_path / "map.pmtiles", [file], counted)


def test_an_interrupted_run_leaves_the_old_map_and_nothing_else(tmp_path: Path) -> None:
    file = write_raster(tmp_path / "ortho.tif", quarters(), cell_m=0.1)
    out = tmp_path / "map.pmtiles"
    out.write_bytes(b"the old one")

    @contextmanager
    def interrupted(_total: int) -> Iterator[pyramid_module.Advance]:
        def advance(_: int) -> None:
            raise KeyboardInterrupt

        yield advance

    with pytest.raises(KeyboardInterrupt):
        make_basemap(out, [file], interrupted)
    assert out.read_bytes() == b"the old one"
    assert {path.name for path in tmp_path.iterdir()} == {"ortho.tif", "map.pmtiles"}


def overlay(inner: str) -> str:
    return f"<kml><GroundOverlay>{inner}</GroundOverlay></kml>"


ICON = "<Icon><href>map.png</href></Icon>"


@pytest.mark.parametrize(
    ("kml", "reason"),
    [
        ("<kml><Placemark/></kml>", "no ground overlay"),
        ("<kml><NetworkLink/></kml>", "linked parts"),
        (overlay("<Icon><href>https://maps.example.org/a.png</href></Icon>"), "outside of the file"),
        (overlay("<Icon><href>//host/a.png</href></Icon>"), "outside of the file"),
        (overlay("<Icon><href>b.png</href></Icon>"), "b.png is not in the file"),
        (overlay("<Icon/>"), "names no picture"),
        (overlay(ICON), "has no LatLonBox"),
        (overlay(f"{ICON}<LatLonBox><north>4</north></LatLonBox>"), "incomplete"),
        (
            overlay(f"{ICON}<LatLonBox><north>4</north><south>5</south><east>2</east><west>1</west></LatLonBox>"),
            "no place",
        ),
        ("<kml", "cannot be read as KML"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><kml>&b;</kml>', "cannot be read as KML"),
    ],
)
def test_a_kmz_without_a_usable_overlay_is_refused(tmp_path: Path, kml: str, reason: str) -> None:
    file = write_kmz(tmp_path / "bad.kmz", {"map.png": png(quarters())}, kml=kml)
    with pytest.raises(InputDataError, match=reason):
        made(tmp_path / "map.pmtiles", file)
    assert not (tmp_path / "map.pmtiles").exists()


def test_files_that_are_no_maps_are_refused_by_name(tmp_path: Path) -> None:
    heights = np.zeros((20, 20, 1), dtype=np.float32)
    text = tmp_path / "notes.tif"
    text.write_text("no map")
    cut = tmp_path / "cut.tif"
    cut.write_bytes(b"II*\0" + bytes(8))
    no_zip = tmp_path / "none.kmz"
    no_zip.write_bytes(b"no archive")
    no_database = tmp_path / "none.mbtiles"
    no_database.write_bytes(b"no database")
    fake = write_kmz(tmp_path / "fake.kmz", {"map.png": b"no picture"})
    for file, reason in [
        (write_raster(tmp_path / "nowhere.tif", quarters(), crs=None), "does not state its coordinate system"),
        (write_raster(tmp_path / "dem.tif", heights), r"float32 values.*\[terrain\]"),
        (write_raster(tmp_path / "many.tif", np.zeros((20, 20, 5), dtype=np.uint8)), "5 bands"),
        (text, "neither GeoTIFF"),
        (cut, "no GeoTIFF or GeoPackage"),
        (no_zip, "no KMZ"),
        (fake, "neither PNG"),
        (no_database, "no MBTiles"),
        (write_mbtiles(tmp_path / "empty.mbtiles", {}, {"format": "png"}), "holds no tiles"),
        (write_mbtiles(tmp_path / "odd.mbtiles", {(0, 0, 0): b"x"}, {"format": "mp3"}), "kind 'mp3'"),
        (write_mbtiles(tmp_path / "off.mbtiles", {(1, 5, 0): b"x"}, {"format": "png"}), "tile 1/5/0 is damaged"),
        (tmp_path / "gone.tif", "gone.tif"),
    ]:
        with pytest.raises(InputDataError, match=reason) as caught:
            made(tmp_path / "map.pmtiles", file)
        assert file.name in str(caught.value)
    assert not (tmp_path / "map.pmtiles").exists()


def test_what_does_not_go_together_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ortho = write_raster(tmp_path / "ortho.tif", quarters(), cell_m=0.1)
    tiles = write_mbtiles(tmp_path / "m.mbtiles", {(0, 0, 0): b"x"}, {"format": "png"})
    with pytest.raises(ConfigurationError, match="give it alone"):
        made(tmp_path / "map.pmtiles", tiles, ortho)
    with pytest.raises(ConfigurationError, match="give it alone"):
        made(tmp_path / "map.pmtiles", tiles, max_zoom=3)
    with pytest.raises(ConfigurationError, match=r"end with \.pmtiles"):
        made(tmp_path / "map.tif", ortho)
    with pytest.raises(ConfigurationError, match="cannot be written"):
        made(tmp_path / "none" / "map.pmtiles", ortho)
    monkeypatch.setattr(pyramid_module, "MAX_TILES", 2)
    with pytest.raises(InputDataError, match="smaller --max-zoom"):
        made(tmp_path / "map.pmtiles", ortho)


def test_a_map_of_nothing_is_refused(tmp_path: Path) -> None:
    file = write_raster(tmp_path / "black.tif", np.zeros((20, 20, 3), dtype=np.uint8), nodata=0)
    with pytest.raises(InputDataError, match="no visible pixels"):
        made(tmp_path / "map.pmtiles", file)
