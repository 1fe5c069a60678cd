"""Elevation models: heights at places, whatever the files' coordinate systems, datums and tiles are."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.elevation import tile as tile_module
from aos_gcs.elevation.datum import VerticalDatum
from aos_gcs.elevation.geoid import Geoid, find_geoid
from aos_gcs.elevation.model import ElevationModel, ModelKind
from aos_gcs.errors import AosError, ConfigurationError, InputDataError
from aos_gcs.imaging.surfaces.dem_files import read_dem
from tests.fakes.elevation_files import PLACE_DEG, centres_deg, ground_m, write_geoid, write_model

pytest.importorskip("rasterio", reason="needs the extra geo")

SYSTEMS = {"EPSG:32633+5773": 5.0, "EPSG:31255+5773": 5.0, "EPSG:4326+5773": 5e-5}
"""Coordinate systems in metres, of another horizontal datum, and in degrees, with cells of about 5 m."""


def opened(*paths: Path, **options: object) -> ElevationModel:
    return ElevationModel(paths, ModelKind.TERRAIN, **options)  # type: ignore[arg-type]


def places(count: int, reach_m: float = 150.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    offsets_m = rng.uniform(-reach_m, reach_m, (2, count))
    return PLACE_DEG[0] + offsets_m[0] / 111_200.0, PLACE_DEG[1] + offsets_m[1] / 75_200.0


@pytest.mark.parametrize(("crs", "cell"), SYSTEMS.items())
def test_heights_are_those_of_the_ground(tmp_path: Path, crs: str, cell: float) -> None:
    model = opened(write_model(tmp_path / "dtm.tif", crs, cell=cell))
    latitude, longitude = places(1000)
    # Between cells of 5 m, hills are bent by 2 cm.
    assert model.heights_amsl_m(latitude, longitude) == pytest.approx(ground_m(latitude, longitude), abs=0.05)
    assert model.datum.datum is VerticalDatum.EGM96
    assert model.cell_m == pytest.approx((5.0, 5.0), rel=0.4)
    south, west, north, east = model.bounds_deg()
    assert south < PLACE_DEG[0] < north
    assert west < PLACE_DEG[1] < east


@pytest.mark.skipif(shutil.which("gdallocationinfo") is None, reason="needs Debian's gdal-bin")
@pytest.mark.parametrize(("crs", "cell"), SYSTEMS.items())
def test_heights_agree_with_gdal(tmp_path: Path, crs: str, cell: float) -> None:
    """GDAL's tool tells the height of the cell that a place lies in: compared at the centres of cells."""
    path = write_model(tmp_path / "dtm.tif", crs, cell=cell)
    model = opened(path)
    rng = np.random.default_rng(3)
    rows, columns = rng.integers(0, 120, 1000), rng.integers(0, 100, 1000)
    lines = "".join(f"{column} {row}\n" for row, column in zip(rows, columns, strict=True))
    answer = subprocess.run(  # noqa: S603 - a peer with numbers as its input
        [str(shutil.which("gdallocationinfo")), "-valonly", str(path)],
        input=lines,
        capture_output=True,
        text=True,
        check=True,
    )
    expected = np.array(answer.stdout.split(), dtype=float)
    heights = model.heights_amsl_m(*centres_deg(crs, cell, rows, columns))
    assert heights == pytest.approx(expected, abs=0.1)


def test_tiles_are_one_model_without_seams(tmp_path: Path) -> None:
    whole = opened(write_model(tmp_path / "whole.tif", "EPSG:32633+5773"))
    parts = [
        write_model(tmp_path / f"{row}_{column}.tif", "EPSG:32633+5773", size=(60, 50), first=(row, column))
        for row in (60, 0)
        for column in (0, 50)
    ]
    latitude, longitude = places(2000)
    tiled = opened(*parts)
    assert tiled.heights_amsl_m(latitude, longitude) == pytest.approx(
        whole.heights_amsl_m(latitude, longitude), abs=1e-3
    )
    assert tiled.bounds_deg() == pytest.approx(whole.bounds_deg(), abs=1e-9)


def test_holes_and_the_outside_have_no_height(tmp_path: Path) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[60, 50] = np.nan
    model = opened(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights))
    holes = model.holes(10**6)
    assert holes is not None
    assert (holes.count, holes.cells) == (1, 12_000)
    assert holes.first_deg is not None
    assert np.isnan(model.heights_amsl_m(*holes.first_deg))
    # Three cells away the ground is known; beyond the edge of the model it is not.
    assert model.heights_amsl_m(holes.first_deg[0] + 15 / 111_200, holes.first_deg[1]) == pytest.approx(700.0)
    assert np.isnan(model.heights_amsl_m(PLACE_DEG[0] + 1.0, PLACE_DEG[1]))
    assert np.isnan(model.heights_amsl_m(np.nan, PLACE_DEG[1]))
    assert model.holes(100) is None


def test_places_at_the_edge_take_the_height_of_their_cell(tmp_path: Path) -> None:
    model = opened(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773"))
    latitude, longitude = centres_deg("EPSG:32633", 5.0, np.array(0), np.array(50))
    for outwards_m, is_known in ((2.0, True), (3.0, False)):
        height = model.heights_amsl_m(latitude + outwards_m / 111_200, longitude)
        assert bool(np.isfinite(height)) is is_known


def test_undulations_are_those_of_the_grid_of_proj() -> None:
    geoid = find_geoid()
    if geoid is None or geoid.grid.suffix != ".gtx":
        pytest.skip("no grid of EGM96 is installed (Debian: proj-data)")
    content = geoid.grid.read_bytes()
    south, west, step_deg, _, rows, columns = struct.unpack(">4d2i", content[:40])
    grid_m = np.frombuffer(content[40:], ">f4").reshape(rows, columns)
    rng = np.random.default_rng(1)
    latitude_deg, longitude_deg = rng.uniform(-85.0, 85.0, 1000), rng.uniform(-180.0, 179.0, 1000)
    row, column = (latitude_deg - south) / step_deg, (longitude_deg - west) / step_deg
    below, left = row.astype(np.int64), column.astype(np.int64)
    up, along = row - below, column - left
    southern_m = (1.0 - along) * grid_m[below, left] + along * grid_m[below, (left + 1) % columns]
    northern_m = (1.0 - along) * grid_m[below + 1, left] + along * grid_m[below + 1, (left + 1) % columns]
    expected_m = (1.0 - up) * southern_m + up * northern_m
    assert geoid.undulation_m(latitude_deg, longitude_deg) == pytest.approx(expected_m, abs=1e-6)


@pytest.mark.skipif(shutil.which("GeoidEval") is None, reason="needs Debian's geographiclib-tools")
def test_undulations_are_those_of_geographiclib(tmp_path: Path) -> None:
    geoid = find_geoid()
    if geoid is None or geoid.grid.suffix != ".gtx":
        pytest.skip("no grid of EGM96 is installed (Debian: proj-data)")
    content = geoid.grid.read_bytes()
    _, west, step_deg, _, rows, columns = struct.unpack(">4d2i", content[:40])
    northern_first_m = np.frombuffer(content[40:], ">f4").reshape(rows, columns)[::-1]
    from_greenwich_m = np.roll(northern_first_m, round(west / step_deg), axis=1)
    header = (
        "P5\n# Geoid file in PGM format for the GeographicLib::Geoid class\n# Offset -108\n# Scale 0.003\n"
        f"# Origin 90N 0E\n# AREA_OR_POINT Point\n{columns} {rows}\n65535\n"
    )
    samples = np.round((from_greenwich_m + 108.0) / 0.003).astype(">u2").tobytes()
    (tmp_path / "grid.pgm").write_bytes(header.encode() + samples)
    rng = np.random.default_rng(1)
    latitude_deg, longitude_deg = rng.uniform(-89.9, 89.9, 1000), rng.uniform(-179.9, 179.9, 1000)
    lines = [f"{latitude:.9f} {longitude:.9f}" for latitude, longitude in zip(latitude_deg, longitude_deg, strict=True)]
    evaluated = subprocess.run(  # noqa: S603 - a tool of Debian
        [str(shutil.which("GeoidEval")), "-n", "grid", "-d", str(tmp_path), "-l"],
        input="\n".join(lines),
        capture_output=True,
        text=True,
        check=True,
    )
    expected_m = np.array(evaluated.stdout.split(), dtype=np.float64)
    assert geoid.undulation_m(latitude_deg, longitude_deg) == pytest.approx(expected_m, abs=0.003)


def test_ellipsoidal_heights_are_brought_to_sea_level(tmp_path: Path) -> None:
    path = write_model(tmp_path / "dsm.tif", "EPSG:4979", cell=5e-5)
    geoid = Geoid(write_geoid(tmp_path / "geoid.gtx", 45.0, slope_m_per_deg=2.0))
    assert geoid.undulation_m(PLACE_DEG[0] + 0.5, PLACE_DEG[1]) == pytest.approx(46.0, abs=1e-4)
    model = opened(path, geoid=geoid)
    assert model.datum.datum is VerticalDatum.ELLIPSOID
    latitude, longitude = places(50)
    expected = ground_m(latitude, longitude) - 45.0 - 2.0 * (latitude - PLACE_DEG[0])
    assert model.heights_amsl_m(latitude, longitude) == pytest.approx(expected, abs=0.05)
    with pytest.raises(ConfigurationError, match="error would be up to 100 m"):
        opened(path)


def test_the_geoid_is_unknown_beyond_its_grid_and_named_when_absent(tmp_path: Path) -> None:
    geoid = Geoid(write_geoid(tmp_path / "geoid.gtx", 45.0))
    assert np.isnan(geoid.undulation_m(-30.0, 100.0))
    with pytest.raises(ConfigurationError, match="does not exist"):
        find_geoid(tmp_path / "absent.gtx")
    (tmp_path / "text.gtx").write_text("no grid")
    with pytest.raises(InputDataError, match="not a grid file that PROJ can read"):
        find_geoid(tmp_path / "text.gtx")


def test_the_datum_is_stated_by_the_file_or_by_the_operator(tmp_path: Path) -> None:
    plain = write_model(tmp_path / "plain.tif", "EPSG:32633")
    with pytest.raises(InputDataError, match="does not state its vertical datum"):
        opened(plain)
    assert opened(plain, datum=VerticalDatum.EGM2008).datum.datum is VerticalDatum.EGM2008
    austrian = write_model(tmp_path / "gha.tif", "EPSG:31255+5778")
    assert opened(austrian).datum.name == "GHA height"
    assert opened(austrian).sigma_m > 0.0
    with pytest.raises(ConfigurationError, match="is GHA height"):
        opened(austrian, datum=VerticalDatum.ELLIPSOID)
    with pytest.raises(InputDataError, match="different vertical datums"):
        opened(plain, write_model(tmp_path / "egm.tif", "EPSG:32633+5773", first=(0, 100)))


def refused(path: Path, message: str, kind: type[AosError] = InputDataError, **options: object) -> None:
    with pytest.raises(kind, match=message):
        opened(path, **options).holes(10**9)


def test_files_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    import rasterio  # noqa: PLC0415
    from rasterio.transform import Affine  # noqa: PLC0415

    feet = np.full((120, 100), 11_000.0, dtype=np.float32)
    egm96 = "EPSG:32633+5773"
    (tmp_path / "text.tif").write_text("no raster")
    refused(tmp_path / "absent.tif", "does not exist")
    refused(tmp_path / "text.tif", "cannot be read")
    refused(_plain(tmp_path), "states no coordinate system")
    refused(write_model(tmp_path / "us.tif", "EPSG:6350+6360"), "are in US survey foot")
    refused(write_model(tmp_path / "high.tif", egm96, heights=feet), "Are they in feet")
    refused(
        write_model(tmp_path / "deep.tif", egm96, heights=-9999 * np.ones((120, 100), np.float32), nodata=None),
        "as holes",
    )
    refused(write_model(tmp_path / "turned.tif", egm96, transform=Affine(5, 1, 0, 1, -5, 0)), "is turned")
    named = write_model(tmp_path / "named.tif", egm96)
    with rasterio.open(named, "r+") as dataset:
        dataset.units = ("ft",)
    refused(named, "are in 'ft'")
    far = write_model(tmp_path / "far.tif", egm96, transform=Affine(5, 0, 9e8, 0, -5, 9e9))
    refused(far, "lies off the earth, at latitudes from inf")
    refused(
        write_model(tmp_path / "pole.tif", "EPSG:4326+5773", transform=Affine(0.5, 0, 14, 0, -0.5, 95)), "to 95 and"
    )
    refused(tmp_path / "\udcff.tif", "its name is not UTF-8")
    refused(write_model(tmp_path / "ok.tif", egm96), "is not known", ConfigurationError, crs="EPSG:999999")
    with pytest.raises(InputDataError, match="do not lie on one grid"):
        opened(tmp_path / "ok.tif", write_model(tmp_path / "fine.tif", egm96, cell=2.0))
    with pytest.raises(InputDataError, match="warp them to one coordinate system"):
        opened(tmp_path / "ok.tif", write_model(tmp_path / "gk.tif", "EPSG:31255+5773"))


def test_heights_have_the_scale_that_their_file_states(tmp_path: Path) -> None:
    """Decimetres above 500 m as whole numbers, as GDAL's tools write and read them."""
    import rasterio  # noqa: PLC0415

    latitude, longitude = places(200)
    stored = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773")
    with rasterio.open(stored) as dataset:
        heights, profile = dataset.read(1), dataset.profile | {"dtype": "int16"}
    with rasterio.open(stored, "w", **profile) as dataset:
        # GDAL forgets them once the header is written.
        dataset.scales, dataset.offsets = (0.1,), (500.0,)
        dataset.write(np.round((heights - 500.0) * 10.0).astype(np.int16), 1)
    assert opened(stored).heights_amsl_m(latitude, longitude) == pytest.approx(ground_m(latitude, longitude), abs=0.11)
    # As the focal surface of images, too; the middle lies between two cells.
    x, y = 443_515.0659, 5_261_002.3069
    assert read_dem(stored).z_m(x, y) == pytest.approx(ground_m(*PLACE_DEG), abs=0.2)


def test_pictures_and_other_rasters_are_no_heights(tmp_path: Path) -> None:
    from rasterio.transform import Affine  # noqa: PLC0415

    egm96 = "EPSG:32633+5773"
    picture = write_model(tmp_path / "ortho.tif", egm96, count=3, dtype="uint8", nodata=None, photometric="rgb")
    with pytest.raises(InputDataError, match="is a picture"):
        read_dem(picture)
    refused(picture, "is a picture")
    refused(write_model(tmp_path / "two.tif", egm96, count=2), r"has 2 bands: extract the one with the heights")
    refused(write_model(tmp_path / "complex.tif", egm96, dtype="complex64"), "complex numbers")
    refused(write_model(tmp_path / "nan.tif", egm96, transform=Affine(float("nan"), 0, 0, 0, -5, 0)), "is not known")
    refused(write_model(tmp_path / "flat.tif", egm96, transform=Affine(0, 0, 5, 0, 0, 5)), "is not known")
    asc = tmp_path / "short.asc"
    asc.write_text("ncols 1000000\nnrows 1000000\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2 3\n")
    refused(asc, "is incomplete", crs="EPSG:32633")
    os.mkfifo(tmp_path / "pipe.tif")
    refused(tmp_path / "pipe.tif", "is not a file")
    refused(Path("/vsicurl/http://127.0.0.1:9/dtm.tif"), "does not exist")
    cut = write_model(tmp_path / "cut.tif", egm96)
    cut.write_bytes(cut.read_bytes()[: cut.stat().st_size // 2])
    with pytest.raises(InputDataError, match="damaged or incomplete: copy it again"):
        opened(cut).holes(10**6)


def test_a_file_that_can_only_be_read_as_a_whole_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tile_module, "_MAX_BLOCK_BYTES", 40_000)
    model = {"heights": np.full((120, 100), 700.0, dtype=np.float32), "crs": "EPSG:32633+5773"}
    refused(
        write_model(tmp_path / "whole.tif", blockysize=120, compress="deflate", **model), "blocks of 120 x 100 heights"
    )
    opened(write_model(tmp_path / "rows.tif", blockysize=16, **model))


def test_what_was_never_written_is_a_hole(tmp_path: Path) -> None:
    """GDAL reads it as zeros, which would be the sea."""
    import rasterio  # noqa: PLC0415

    heights = np.full((120, 100), 700.0, dtype=np.float32)
    stored = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights, nodata=None)
    with rasterio.open(stored) as dataset:
        profile = dataset.profile | {"tiled": True, "blockxsize": 16, "blockysize": 16}
    with rasterio.open(stored, "w", SPARSE_OK=True, **profile) as dataset:
        dataset.write(heights[:32, :20], 1, window=rasterio.windows.Window(30, 16, 20, 32))
    model = opened(stored)
    holes = model.holes(10**6)
    assert holes is not None
    # Blocks of 16 cells: three columns of them and two rows were begun.
    assert holes.count == 120 * 100 - 32 * 48
    assert np.isfinite(model.cells_of_files(np.arange(10, 60), np.arange(5, 70))).sum() == 32 * 48


@pytest.mark.parametrize("value", [-9999.0, 0.0, 701.0, float("nan")])
def test_holes_are_found_whatever_value_stands_for_them(tmp_path: Path, value: float) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[60:62, 50] = np.nan
    holes = opened(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights, nodata=value)).holes(10**6)
    assert holes is not None
    assert holes.count == 2


def test_infinite_heights_are_holes(tmp_path: Path) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[60, 50] = np.inf
    holes = opened(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights)).holes(10**6)
    assert holes is not None
    assert holes.count == 1


def test_a_system_that_contradicts_the_file_is_refused(tmp_path: Path) -> None:
    path = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773")
    assert opened(path, crs="EPSG:32633").crs_name == opened(path).crs_name
    refused(path, "according to the file, not in WGS 84 / UTM zone 1N", ConfigurationError, crs="EPSG:32601")
    refused(_plain(tmp_path), "no places in a plane", ConfigurationError, crs="EPSG:5773")


def _plain(folder: Path) -> Path:
    """An ASC file without its coordinate system."""
    path = write_model(folder / "plain.asc", "EPSG:32633")
    path.with_suffix(".prj").unlink()
    return path


def test_an_asc_file_may_have_its_system_told(tmp_path: Path) -> None:
    path = _plain(tmp_path)
    model = opened(path, crs="EPSG:32633", datum=VerticalDatum.NATIONAL)
    assert model.heights_amsl_m(*PLACE_DEG) == pytest.approx(ground_m(*PLACE_DEG), abs=0.05)


@settings(max_examples=30, deadline=None)
@given(st.floats(), st.floats())
def test_any_numbers_give_a_height_of_the_model_or_none(
    tmp_path_factory: pytest.TempPathFactory, latitude_deg: float, longitude_deg: float
) -> None:
    folder = tmp_path_factory.getbasetemp() / "elevation"
    folder.mkdir(exist_ok=True)
    path = folder / "dtm.tif"
    model = opened(path if path.exists() else write_model(path, "EPSG:32633+5773"))
    height = model.heights_amsl_m(latitude_deg, longitude_deg)
    assert np.isnan(height) or 700.0 < height < 900.0
