"""The height at which returns by autopilots clear the ground."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.terrain.ground import EnuBounds, ground_within
from aos_gcs.planning.terrain.returns import ReturnClearance, return_clearance
from tests.fakes.relief import ORIGIN, Relief, hill, level, terrain, write_relief

SQUARE = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0)


def clearance(folder: Path, relief: Relief, *homes_m: tuple[float, float]) -> ReturnClearance | None:
    settings = terrain(write_relief(folder / "ground.tif", relief))
    ground = ground_within(settings, ORIGIN, EnuBounds(-300.0, -300.0, 300.0, 300.0))
    legs = planned_legs(PLAN, 0.0)
    standing_m = [np.array([*each, 0.0]) for each in homes_m]
    return return_clearance(PLAN, legs, standing_m, ground=ground, frame=LocalFrame(ORIGIN), floor_m=25.0)


@pytest.mark.parametrize(
    ("east_m", "north_m", "height_m"),
    [
        pytest.param(10.0, 60.0, 18.0, id="in the search area"),
        pytest.param(0.0, -100.0, 18.0, id="on the way home"),
        pytest.param(-250.0, -100.0, 0.0, id="where nothing flies"),
    ],
)
def test_the_highest_ground_between_vehicles_and_home_decides(
    tmp_path: Path, east_m: float, north_m: float, height_m: float
) -> None:
    found = clearance(tmp_path, hill(east_m, north_m, 18.0), (0.0, -20.0), (0.0, -200.0))
    assert found is not None
    assert found.ground_up_m == pytest.approx(height_m, abs=0.3)
    assert found.least_up_m == found.ground_up_m + 25.0
    if height_m:
        places = re.search(r"\((\d+) m (east|west), (\d+) m (north|south) of the origin\)", found.place)
        assert places is not None
        east, north = (int(places[1 + i]) * (1 if places[2 + i] in {"east", "north"} else -1) for i in (0, 2))
        assert np.hypot(east - east_m, north - north_m) < 6.0


def test_ground_below_the_origin_lowers_what_returns_have_to_clear(tmp_path: Path) -> None:
    found = clearance(tmp_path, level(-12.0), (0.0, -20.0))
    assert found is not None
    assert found.least_up_m == pytest.approx(13.0, abs=0.1)


def test_without_any_known_ground_nothing_is_claimed(tmp_path: Path) -> None:
    def far_ground(east: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where(np.hypot(east, north) < 340.0, np.nan, 0.0)

    assert clearance(tmp_path, far_ground, (0.0, -20.0)) is None
