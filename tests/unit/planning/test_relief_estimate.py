"""Estimates over relief: the swath above high ground, and climbs from the ground to the layers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.estimate import CLIMB_MPS, SINK_MPS, PlanEstimate, estimate_plan
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.terrain.relief_estimate import estimate_over_ground
from tests.fakes.relief import ORIGIN, Relief, level, terrain, write_relief

SQUARE = ((-100.0, 0.0), (100.0, 0.0), (100.0, 100.0), (-100.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0, launch_enu_m=(0.0, -20.0), lowest_layer_m=60.0)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings(), origin=ORIGIN)
LEVEL = estimate_plan(PLAN, 0.0)


def over(tmp_path: Path, relief: Relief, plan: MissionPlan = PLAN, **values: Any) -> PlanEstimate:
    file = write_relief(tmp_path / "ground.tif", relief)
    return estimate_over_ground(plan, replace(SETTINGS, terrain=terrain(file, **values)), None, {})


def test_level_ground_changes_nothing(tmp_path: Path) -> None:
    assert estimate_over_ground(PLAN, SETTINGS, None, {}) == LEVEL
    found = over(tmp_path, level(0.0))
    assert found.covered_fraction == pytest.approx(LEVEL.covered_fraction, abs=0.01)
    assert found.flight_s == pytest.approx(LEVEL.flight_s, abs=0.1)
    assert found.climb_m == pytest.approx(LEVEL.climb_m, abs=0.1)


def test_high_ground_leaves_gaps_between_the_legs(tmp_path: Path) -> None:
    """Views of legs over a plateau 40 m high are a third as wide as planned."""

    def plateau(_: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where(north > 50.0, 40.0, 0.0)

    found = over(tmp_path, plateau)
    assert LEVEL.covered_fraction == pytest.approx(1.0, abs=0.01)
    assert 0.5 < found.covered_fraction < 0.85
    settings = replace(
        SETTINGS, terrain=terrain(write_relief(tmp_path / "ground.tif", plateau), floor_above_ground_m=10.0)
    )
    texts = [problem.text for problem in check_plan(PLAN, settings)]
    assert any("between them on high ground" in text for text in texts)


def test_climbs_begin_in_the_valley_and_end_where_vehicles_land(tmp_path: Path) -> None:
    plan = replace(PLAN, return_enu_m=(0.0, 120.0))

    def valley(_: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.clip(-15.0 + 0.25 * (north + 20.0), -15.0, 20.0)

    found, without = over(tmp_path, valley, plan), estimate_plan(plan, 0.0)
    assert found.climb_m == pytest.approx(plan.highest_layer_m + 15.0, abs=0.5)
    assert found.flight_s - without.flight_s == pytest.approx(15.0 / CLIMB_MPS - 20.0 / SINK_MPS, abs=1.0)
    assert found.battery_fraction == pytest.approx(found.flight_s / plan.endurance_s)


def test_layers_that_follow_the_ground_climb_along_it_and_see_as_wide_as_planned(tmp_path: Path) -> None:
    found = over(tmp_path, lambda _, north: 0.08 * np.maximum(north, 0.0), follow=True)
    assert found.covered_fraction > 0.97
    rises_m = 0.08 * 100.0 * len(found.legs) / 2.0
    assert found.climb_m > LEVEL.climb_m + 0.5 * rises_m


def test_a_model_that_cannot_be_read_leaves_the_estimate_of_level_ground(tmp_path: Path) -> None:
    settings = replace(SETTINGS, terrain=terrain(tmp_path / "gone.tif"))
    assert estimate_over_ground(PLAN, settings, None, {}) == LEVEL
