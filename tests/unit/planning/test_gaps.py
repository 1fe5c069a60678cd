"""Gaps of a search: which stretches are flown again, and what they gain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.planning.gaps import find_gap_legs
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import ForestSettings

HALF_M = 100
SQUARE = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
PLAN = MissionPlan(
    vehicles=3,
    area_enu_m=SQUARE,
    forest=ForestSettings(18.0, 4.4, occlusion=0.84),
    line_spacing_m=16.0,
    leg_spacing_m=50.0,
)


def searched(views: int, gap: tuple[slice, slice] | None = None) -> ViewRaster:
    """The square, seen from so many directions, but for a part of it that nobody has looked at."""
    counts = np.full((2 * HALF_M, 2 * HALF_M), views, dtype=np.uint8)
    if gap is not None:
        counts[gap] = 0
    return ViewRaster(-HALF_M, -HALF_M, counts)


def test_a_gap_is_flown_again_where_it_is_and_nothing_else() -> None:
    # 60 m x 40 m in the north-east
    raster = searched(55, (slice(20, 60), slice(130, 190)))
    found = find_gap_legs(raster, PLAN, 0.0, from_m=(0.0, 0.0), within_s=600.0, pod=0.97)
    assert found is not None
    assert found.legs
    assert found.detection_before < 0.97 <= found.detection_after
    middles_m = np.array([np.add(leg.start_enu_m, leg.end_enu_m) / 2.0 for leg in found.legs])
    assert (np.abs(middles_m - [60.0, 60.0]) < 35.0).all()
    assert sum(leg.length_m for leg in found.legs) < 250.0


def test_nothing_is_flown_again_where_enough_is_seen_or_no_time_is_left() -> None:
    for views, within_s in ((60, 600.0), (5, 20.0)):
        found = find_gap_legs(searched(views), PLAN, 0.0, from_m=(0.0, 0.0), within_s=within_s, pod=0.9)
        assert found is not None
        assert found.legs == ()
        assert found.takes_s == 0.0
        assert found.detection_after == found.detection_before


def test_more_time_gains_more_and_less_of_what_is_well_seen() -> None:
    def gain(views: int, within_s: float) -> float:
        found = find_gap_legs(searched(views), PLAN, 0.0, from_m=(0.0, 0.0), within_s=within_s, pod=1.0)
        assert found is not None
        assert found.takes_s <= within_s
        return found.detection_after - found.detection_before

    assert gain(10, 300.0) > gain(10, 120.0) > gain(30, 120.0) > 0.0


def test_zones_count_for_nothing_and_without_a_forest_nothing_is_known() -> None:
    zone = ((30.0, 40.0), (90.0, 40.0), (90.0, 80.0), (30.0, 80.0))
    raster = searched(55, (slice(20, 60), slice(130, 190)))
    barred = find_gap_legs(raster, replace(PLAN, no_go_enu_m=(zone,)), 0.0, from_m=(0, 0), within_s=600.0, pod=0.97)
    assert barred is not None
    assert barred.legs == ()
    assert barred.detection_before == pytest.approx(0.99, abs=0.01)
    assert find_gap_legs(raster, replace(PLAN, forest=None), 0.0, from_m=(0, 0), within_s=600.0, pod=0.9) is None
