"""The profile of a plan: the ground below each leg, and the heights above it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.check import examine_plan
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.terrain import profile as profile_module
from aos_gcs.planning.terrain.profile import LegProfile, plan_profile
from tests.fakes.relief import ORIGIN, Relief, hill, terrain, write_relief

SQUARE = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings(), origin=ORIGIN)


def profile_of(settings: MissionSettings, plan: MissionPlan = PLAN) -> tuple[LegProfile, ...]:
    return plan_profile(plan, settings, None, {}, examine_plan(plan, settings).legs)


def over(tmp_path: Path, relief: Relief, **values: Any) -> MissionSettings:
    return replace(SETTINGS, terrain=terrain(write_relief(tmp_path / "ground.tif", relief, cell=2.0), **values))


def test_level_ground_has_straight_lines_above_the_origin() -> None:
    legs = examine_plan(PLAN, SETTINGS).legs
    profile = profile_of(SETTINGS)
    assert len(profile) == len(legs) > 1
    for leg, one in zip(legs, profile, strict=True):
        assert one.distances_m.tolist() == [0.0, leg.length_m]
        assert (one.highest_ground_m == 0.0).all()
        assert (one.floor_m == 30.0).all()
        assert (one.ceiling_m == 46.0).all()
    (first, *_) = profile_of(SETTINGS, replace(PLAN, floor_m=20.0, ceiling_m=90.0))
    assert (first.floor_m == 20.0).all()
    assert (first.ceiling_m == 90.0).all()


def test_the_ground_is_that_below_the_whole_line_of_the_swarm(tmp_path: Path) -> None:
    """A ridge along the leg, beside its middle, counts."""
    legs = examine_plan(PLAN, SETTINGS).legs
    leg = legs[0]
    aside_m = leg.start_enu_m[0] + 2.0

    def ridge(east: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where(np.abs(east - aside_m) < 1.5, 20.0, 0.1 * north)

    profile = profile_of(over(tmp_path, ridge))[0]
    north_m = leg.start_enu_m[1] + profile.distances_m * leg.direction_enu[1]
    inner = slice(2, -2)
    assert profile.lowest_ground_m[inner] == pytest.approx(0.1 * north_m[inner], abs=0.7)
    assert (profile.highest_ground_m >= 19.9).all()
    assert profile.floor_m == pytest.approx(profile.highest_ground_m + 30.0)
    assert profile.ceiling_m == pytest.approx(profile.lowest_ground_m + 120.0)
    assert (profile.surface_m == 0.0).all()


def test_a_plan_that_meets_the_ground_has_a_profile_that_shows_where(tmp_path: Path) -> None:
    settings = over(tmp_path, hill(-33.0, 60.0, 25.0))
    assert any(problem.blocking for problem in examine_plan(PLAN, settings).problems)
    highest_m = max(float(one.highest_ground_m.max()) for one in profile_of(settings))
    assert highest_m == pytest.approx(25.0, abs=0.3)


def test_layers_that_follow_the_ground_are_offset_from_their_surface(tmp_path: Path) -> None:
    settings = over(tmp_path, lambda _, north: 0.08 * north, follow=True)
    for one in profile_of(settings):
        clearance_m = PLAN.lowest_layer_m + one.surface_m - one.highest_ground_m
        assert clearance_m.min() > 34.0
        assert np.ptp(one.surface_m) > 4.0


def test_ground_that_is_not_known_is_a_gap(tmp_path: Path) -> None:
    def holed(_: np.ndarray, north: np.ndarray) -> np.ndarray:
        return np.where((np.abs(north - 50.0) < 8.0), np.nan, 1.0)

    for one in profile_of(over(tmp_path, holed)):
        assert 1 <= np.isnan(one.highest_ground_m).sum() < len(one.distances_m)
        assert np.isnan(one.floor_m).sum() == np.isnan(one.highest_ground_m).sum()


def test_many_legs_share_the_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = over(tmp_path, hill(0.0, 50.0, 4.0))
    assert {len(one.distances_m) for one in profile_of(settings)} == {26}
    monkeypatch.setattr(profile_module, "MAX_SAMPLES", 10)
    assert {len(one.distances_m) for one in profile_of(settings)} == {9}


def test_without_an_origin_or_legs_there_is_no_profile(tmp_path: Path) -> None:
    settings = replace(over(tmp_path, hill(0.0, 50.0, 4.0)), origin=None)
    assert profile_of(settings) == ()
    assert examine_plan(replace(PLAN, area_enu_m=()), SETTINGS).legs == ()
