"""Plans over relief: what meets the ground, leaves the ceiling above it, or is where it is not known."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.elevation.model import ModelKind
from aos_gcs.errors import InputDataError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.plan import MissionPlan, PlanProblem
from aos_gcs.planning.settings import ForestSettings, MissionSettings
from aos_gcs.planning.terrain import ground as ground_module
from aos_gcs.planning.terrain.ground import EnuBounds, ground_heights_m, ground_within
from tests.fakes.relief import ORIGIN, Relief, hill, level, terrain, write_relief

SQUARE = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings(), origin=ORIGIN)
Checked = Callable[..., list[PlanProblem]]
BOUNDS = EnuBounds(-200.0, -200.0, 200.0, 200.0)


def rough(east: np.ndarray, north: np.ndarray) -> np.ndarray:
    return 15.0 * np.sin(east / 7.0) * np.cos(north / 11.0) + 0.2 * east


@pytest.fixture
def checked(tmp_path: Path) -> Checked:
    def check(relief: Relief, plan: MissionPlan = PLAN, **values: Any) -> list[PlanProblem]:
        file = write_relief(tmp_path / "ground.tif", relief)
        settings = replace(SETTINGS, terrain=terrain(file, **values))
        return check_plan(plan, settings)

    return check


@pytest.mark.parametrize(("cell", "most"), [(5.0, 4_000_000), (1.0, 4_000_000), (1.0, 9_000)])
def test_no_ground_is_outside_of_the_bounds_of_its_cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cell: float, most: int
) -> None:
    monkeypatch.setattr(ground_module, "MAX_CELLS", most)
    settings = terrain(write_relief(tmp_path / "rough.tif", rough, cell=cell, reach_m=250.0))
    raster = ground_within(settings, ORIGIN, BOUNDS)
    assert np.prod(raster.shape) <= 1.1 * most
    places_m = np.random.default_rng(1).uniform(-200.0, 200.0, (2000, 2))
    ground_m = ground_heights_m(settings, ORIGIN, places_m)
    lowest_m, highest_m = raster.bounds_at(places_m)
    assert (lowest_m <= ground_m + 1e-3).all()
    assert (ground_m <= highest_m + 1e-3).all()
    if most > 9_000:
        assert (highest_m - lowest_m).max() < 8.0, "the bounds are close"


def test_level_ground_changes_nothing(checked: Checked) -> None:
    assert checked(level(0.0)) == check_plan(PLAN, SETTINGS) == []


def test_a_hill_below_a_leg_is_refused_with_place_and_amount(checked: Checked) -> None:
    (problem,) = checked(hill(20.0, 60.0, 25.0))
    assert problem.field == "lowest_layer_m"
    assert problem.blocking
    assert re.match(r"Search area: at 47\.500\d\d, 14\.250\d\d \((19|2\d) m east, (5[6-9]|6\d) m north", problem.text)
    assert re.search(r"(19\.[5-9]|20\.0) m below the floor of 30 m above ground: raise it to 55 m", problem.text)


def test_the_floor_above_ground_can_be_set(checked: Checked) -> None:
    problems = checked(hill(20.0, 60.0, 25.0), floor_above_ground_m=9.0)
    assert [problem.field for problem in problems if problem.blocking] == []


def test_the_floor_above_ground_keeps_clear_of_a_known_canopy(checked: Checked) -> None:
    """The floor is never above that on level ground."""
    forests = {canopy_m: ForestSettings(canopy_height_m=canopy_m, crown_base_m=5.0) for canopy_m in (14.0, 15.0, 33.0)}
    assert checked(hill(20.0, 60.0, 16.0), replace(PLAN, forest=forests[14.0])) == []
    for canopy_m, floor_m in ((15.0, 20), (33.0, 30)):
        (problem,) = checked(hill(20.0, 60.0, 16.0), replace(PLAN, forest=forests[canopy_m]))
        assert f"below the floor of {floor_m} m above ground" in problem.text


def test_a_model_that_is_replaced_is_read_again(checked: Checked) -> None:
    assert checked(level(0.0)) == []
    (problem,) = checked(hill(20.0, 60.0, 25.0))
    assert problem.field == "lowest_layer_m"


def test_ground_that_was_read_outlasts_its_file(tmp_path: Path) -> None:
    settings = terrain(write_relief(tmp_path / "ground.tif", level(3.0)))
    ground = ground_within(settings, ORIGIN, BOUNDS)
    (tmp_path / "ground.tif").unlink()
    lowest_m, highest_m = ground.bounds_at(np.zeros((1, 2)))
    assert (lowest_m[0], highest_m[0]) == pytest.approx((3.0, 3.0), abs=0.01)
    with pytest.raises(InputDataError, match=r"ground\.tif does not exist"):
        ground_within(settings, ORIGIN, BOUNDS)


def test_a_hill_on_the_way_home_is_refused(checked: Checked) -> None:
    far = replace(PLAN, return_enu_m=(0.0, -250.0))
    (problem,) = checked(hill(0.0, -150.0, 25.0), far)
    assert problem.text.startswith("Way to the search area or home: ")


def test_a_valley_is_refused_where_the_ceiling_above_ground_is_left(checked: Checked) -> None:
    (problem,) = checked(hill(0.0, 50.0, -100.0))
    assert (problem.field, problem.blocking) == ("ceiling_m", True)
    assert "beyond the ceiling of 120 m above ground" in problem.text
    assert checked(hill(0.0, 50.0, -100.0), ceiling_above_ground_m=150.0) == []


def test_a_hole_below_a_leg_is_refused(checked: Checked) -> None:
    def holed(east: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where((np.abs(east) < 8.0) & (np.abs(north - 50.0) < 8.0), np.nan, 0.0)

    (problem,) = checked(holed)
    assert problem.blocking
    assert "the ground is not known at 47.50" in problem.text


def test_a_model_that_ends_before_the_return_point_is_refused(checked: Checked) -> None:
    (problem,) = checked(level(0.0), replace(PLAN, return_enu_m=(0.0, -450.0)))
    assert (problem.field, problem.blocking) == ("return_enu_m", True)
    assert "hole or ends" in problem.text


def test_a_surface_model_is_warned_of(checked: Checked) -> None:
    (problem,) = checked(level(0.0), kind=ModelKind.SURFACE)
    assert not problem.blocking
    assert "surface model" in problem.text


def test_a_wrong_altitude_of_the_origin_is_refused_with_the_difference(checked: Checked) -> None:
    (problem,) = checked(level(31.0))
    assert problem.blocking
    assert "differs by 31.0 m" in problem.text


def test_an_altitude_that_a_vehicle_reports_may_err(tmp_path: Path) -> None:
    file = write_relief(tmp_path / "ground.tif", level(8.0))
    settings = replace(SETTINGS, origin=None, terrain=terrain(file))
    assert check_plan(PLAN, settings, origin=ORIGIN) == []


def test_where_vehicles_stand_is_advice(tmp_path: Path) -> None:
    file = write_relief(tmp_path / "ground.tif", hill(0.0, -150.0, 25.0))
    problems = check_plan(PLAN, replace(SETTINGS, terrain=terrain(file)), {1: (0.0, -250.0), 2: (10.0, -250.0)})
    assert [problem.blocking for problem in problems] == [False]


def test_a_file_that_is_gone_is_refused_by_name(tmp_path: Path) -> None:
    problems = check_plan(PLAN, replace(SETTINGS, terrain=terrain(tmp_path / "gone.tif")))
    assert any(problem.blocking and "gone.tif" in problem.text for problem in problems)
