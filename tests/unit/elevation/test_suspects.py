"""Elevation models that are read without an error and are wrong all the same, and those where longitudes end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("rasterio", reason="needs the extra geo")

from aos_gcs.elevation.datum import VerticalDatum
from aos_gcs.elevation.geoid import Geoid
from aos_gcs.elevation.model import ElevationModel, ModelKind
from aos_gcs.elevation.suspects import overlaps, zeros_at_a_step
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.heights import AmslM
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.planning.terrain.ground import EnuBounds, ground_heights_m, ground_within
from aos_gcs.planning.terrain.suspected_holes import holes_warning
from tests.fakes.elevation_files import PLACE_DEG, write_geoid, write_model
from tests.fakes.relief import ORIGIN, terrain, write_relief

UTM = "EPSG:32633+5773"
SQUARE = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))


def opened(*paths: Path, **options: object) -> ElevationModel:
    return ElevationModel(paths, ModelKind.TERRAIN, **options)  # type: ignore[arg-type]


def level(path: Path, height_m: float, **options: object) -> Path:
    return write_model(path, UTM, heights=np.full((120, 100), height_m, dtype=np.float32), **options)  # type: ignore[arg-type]


def test_a_patch_of_zeros_beside_high_ground_is_told(tmp_path: Path) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[40:60, 50:80] = 0.0
    holes = opened(write_model(tmp_path / "dtm.tif", UTM, heights=heights)).holes(10**6)
    assert holes is not None
    assert holes.suspected is not None
    assert (holes.count, holes.suspected.count) == (0, 600)
    assert opened(tmp_path / "dtm.tif").heights_amsl_m(*holes.suspected.first_deg) == pytest.approx(0.0, abs=0.1)
    assert "600 cells are exactly 0 m" in holes_warning(holes.suspected)


def test_zeros_that_fill_whole_blocks_are_told(tmp_path: Path) -> None:
    heights = np.full((600, 1030), 700.0, dtype=np.float32)
    heights[:512, 512:1024] = 0.0
    holes = opened(write_model(tmp_path / "dtm.tif", UTM, cell=1.0, size=heights.shape, heights=heights)).holes(10**7)
    assert holes is not None
    assert holes.suspected is not None
    assert holes.suspected.count == 512 * 512


def test_a_shore_that_rises_gently_is_no_hole() -> None:
    rising = np.maximum(0.0, np.arange(-20.0, 20.0) * 2.0)[None, :].repeat(5, axis=0)
    assert not zeros_at_a_step(rising).any()
    assert zeros_at_a_step(10.0 * rising).any()


@pytest.mark.parametrize("cell", [1.0, 5.0, 25.0])
def test_plans_warn_of_zeros_that_may_be_holes(tmp_path: Path, cell: float) -> None:
    def ground(east: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where((abs(east) < 30.0) & (abs(north - 60.0) < 30.0), -600.0, 0.0)

    file = write_relief(tmp_path / "ground.tif", ground, cell=cell)
    plan = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0)
    mission = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings(), origin=ORIGIN)
    mission = replace(mission, terrain=terrain(file))
    problems = check_plan(plan, mission)
    assert any("may have holes that are written as 0" in one.text and not one.blocking for one in problems)
    sound = write_relief(tmp_path / "sound.tif", lambda east, _: 0.0 * east, cell=cell)
    assert check_plan(plan, replace(mission, terrain=terrain(sound))) == []


def test_files_that_contradict_each_other_are_refused(tmp_path: Path) -> None:
    """Whichever comes first: a tile in feet, or one of another datum."""
    metres, other = level(tmp_path / "metres.tif", 700.0), level(tmp_path / "other.tif", 745.0, first=(60, 0))
    third = level(tmp_path / "third.tif", 700.0, first=(0, 200))  # which is beside both, and right
    for paths in ((metres, other, third), (other, third, metres)):
        model = opened(*paths)
        for read in (
            lambda: model.heights_amsl_m(PLACE_DEG[0] - 0.0005, PLACE_DEG[1]),  # noqa: B023 - called here
            lambda: model.holes(10**6),  # noqa: B023 - called here
            lambda: model.cells_of_files(np.arange(120), np.arange(100)),  # noqa: B023 - called here
        ):
            with pytest.raises(InputDataError, match=r"overlap and contradict each other by up to 45\.0 m") as error:
                read()
            assert all(f"{path}" in str(error.value) for path in (metres, other))
            assert str(third) not in str(error.value)
        assert model.heights_amsl_m(PLACE_DEG[0] + 0.002, PLACE_DEG[1]) == pytest.approx(700.0), (
            "where one is alone it counts"
        )


def test_files_that_nearly_agree_are_one_model(tmp_path: Path) -> None:
    first, other = level(tmp_path / "first.tif", 700.0), level(tmp_path / "other.tif", 701.0, first=(60, 0))
    model = opened(first, other)
    assert model.heights_amsl_m(PLACE_DEG[0] - 0.0005, PLACE_DEG[1]) == pytest.approx(700.0)
    assert model.holes(10**6) is not None


boxes = st.tuples(*[st.integers(0, 30)] * 2, *[st.integers(1, 12)] * 2).map(
    lambda box: (box[0], box[1], box[0] + box[2], box[1] + box[3])
)


@given(st.lists(boxes, max_size=4), st.integers(1, 9))
@settings(max_examples=50, deadline=None)
def test_bands_cover_what_files_share_and_nothing_else(files: list[tuple[int, int, int, int]], rows: int) -> None:
    counts = np.zeros((50, 50), int)
    for top, left, bottom, right in files:
        counts[top:bottom, left:right] += 1
    covered = np.zeros((50, 50), bool)
    for band, columns in overlaps(files, rows):
        assert len(band) <= rows
        covered[np.ix_(band, columns)] = True
    assert (covered == (counts > 1)).all()


@pytest.mark.parametrize("middle_deg", [-180.0, 180.0])
def test_models_across_the_180th_meridian_have_heights_on_both_sides(tmp_path: Path, middle_deg: float) -> None:
    file = _model_at(tmp_path / "fiji.tif", -16.8, middle_deg)
    model = opened(file)
    longitudes = np.array([179.999, -179.999, 180.0, -180.0])
    heights = model.heights_amsl_m(np.full(4, -16.8), longitudes)
    assert heights == pytest.approx([98.0, 102.0, 100.0, 100.0], abs=0.05)
    origin = replace(ORIGIN, latitude_deg=-16.8, longitude_deg=179.9999, altitude_amsl_m=AmslM(100.0))
    named = TerrainSettings(files=(str(file),), kind=ModelKind.TERRAIN)
    places_m = np.array([(-60.0, 0.0), (60.0, 0.0)])
    expected_m = places_m[:, 0] * 0.02 / 1.065 - 0.2
    assert ground_heights_m(named, origin, places_m) == pytest.approx(expected_m, abs=0.05)
    raster = ground_within(named, origin, EnuBounds(-100.0, -100.0, 100.0, 100.0))
    assert not np.isnan(raster.lowest_m).any()
    assert raster.heights_at(places_m) == pytest.approx(expected_m, abs=0.1)


def test_models_whose_longitudes_count_to_360_have_heights_in_the_west(tmp_path: Path) -> None:
    model = opened(_model_at(tmp_path / "west.tif", 40.0, 250.0))
    assert model.heights_amsl_m(40.0, -109.999) == pytest.approx(102.0, abs=0.05)
    assert model.heights_amsl_m(40.0, 250.001) == pytest.approx(102.0, abs=0.05)
    assert np.isnan(model.heights_amsl_m(40.0, 70.0))


def _model_at(path: Path, latitude_deg: float, longitude_deg: float) -> Path:
    """Write a model in degrees that rises by 2 m per 0.001 degrees to the east, 100 m high in its middle."""
    import rasterio  # noqa: PLC0415 - tests without the extra are skipped
    from rasterio.transform import Affine  # noqa: PLC0415

    count, cell = 200, 5e-5
    west, north = longitude_deg - count / 2 * cell, latitude_deg + count / 2 * cell
    east_deg = (np.arange(count) + 0.5) * cell - count / 2 * cell
    heights = np.broadcast_to(100.0 + 2000.0 * east_deg, (count, count)).astype(np.float32)
    profile = {"driver": "GTiff", "height": count, "width": count, "count": 1, "dtype": "float32", "nodata": -9999.0}
    transform = Affine(cell, 0.0, west, 0.0, -cell, north)
    with rasterio.open(path, "w", crs="EPSG:4326+5773", transform=transform, **profile) as dataset:
        dataset.write(heights, 1)
    return path


def test_heights_above_egm2008_go_through_both_grids(tmp_path: Path) -> None:
    file = level(tmp_path / "dtm.tif", 700.0)
    write_model(file, "EPSG:32633+3855", heights=np.full((120, 100), 700.0, dtype=np.float32))
    egm96, egm2008 = (
        Geoid(write_geoid(tmp_path / f"{name}.gtx", height_m, slope_m_per_deg=slope))
        for name, height_m, slope in (("egm96", 45.0, 0.0), ("egm2008", 45.4, 2.0))
    )
    latitude = PLACE_DEG[0] + np.array([0.0, 0.001])
    exact = opened(file, geoid=egm96, egm2008=egm2008)
    assert exact.datum.datum is VerticalDatum.EGM2008
    assert exact.heights_amsl_m(latitude, PLACE_DEG[1]) == pytest.approx([700.4, 700.402], abs=1e-3)
    assert exact.undulation_m(latitude, np.full(2, PLACE_DEG[1])) == pytest.approx([-0.4, -0.402], abs=1e-3)
    assert exact.sigma_m == pytest.approx(0.1)
    for absent in ({"geoid": egm96}, {"egm2008": egm2008}):
        model = opened(file, **absent)
        assert model.heights_amsl_m(latitude, PLACE_DEG[1]) == pytest.approx(700.0)
        assert model.sigma_m == pytest.approx(0.5)
