"""What a sortie leaves of its area for the next one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aos_gcs.airspace.polygon import Polygon, contains, signed_area_m2
from aos_gcs.planning.legs import ScanLeg, in_passes, scan_legs
from aos_gcs.planning.remaining import remaining_area

AREA: Polygon = ((0.0, 0.0), (90.0, 0.0), (90.0, 60.0), (0.0, 60.0))


def legs_over(area: Polygon, heading_rad: float = 0.0) -> tuple[ScanLeg, ...]:
    direction = np.array((math.sin(heading_rad), math.cos(heading_rad)))
    return scan_legs(area, np.array((-10.0, -10.0)), direction, n=3, spacing_m=10.0, footprint_m=10.0)


def size_m2(area: Polygon | None) -> float:
    return 0.0 if area is None else abs(signed_area_m2(np.array(area)))


def test_strips_of_flown_legs_are_left_out() -> None:
    legs = legs_over(AREA)
    assert len(legs) == 3
    assert remaining_area(AREA, legs, 0, 30.0) == AREA
    assert remaining_area(AREA, legs, 1, 30.0) == ((30.0, 0.0), (90.0, 0.0), (90.0, 60.0), (30.0, 60.0))
    assert size_m2(remaining_area(AREA, legs, 2, 0.0)) == pytest.approx(30.0 * 60.0)
    assert remaining_area(AREA, legs, 3, 0.0) is None


def test_the_whole_area_is_left_until_its_last_pass() -> None:
    legs = in_passes(legs_over(AREA), 2)
    assert [remaining_area(AREA, legs, leg, 30.0, 2) for leg in (1, 2, 3)] == [AREA] * 3
    assert size_m2(remaining_area(AREA, legs, 4, 0.0, 2)) == pytest.approx(60.0 * 60.0, rel=0.05)
    assert remaining_area(AREA, legs, 6, 0.0, 2) is None


def test_the_last_leg_goes_on_where_it_was_left() -> None:
    legs = legs_over(AREA)
    assert size_m2(remaining_area(AREA, legs, 2, 45.0)) == pytest.approx(30.0 * 15.0)
    assert remaining_area(AREA, legs, 2, 57.0) is None, "not worth another flight"
    narrow: Polygon = ((0.0, 0.0), (20.0, 0.0), (20.0, 60.0), (0.0, 60.0))
    (leg,) = legs_over(narrow)
    assert size_m2(remaining_area(narrow, (leg,), 0, 20.0)) == pytest.approx(20.0 * 40.0)


def test_before_the_legs_are_planned_all_is_left() -> None:
    assert remaining_area(AREA, (), 0, 0.0) == AREA


def test_what_cannot_be_told_as_one_polygon_is_the_whole_area() -> None:
    comb: Polygon = (
        (0.0, 0.0),
        (90.0, 0.0),
        (90.0, 20.0),
        (10.0, 20.0),
        (10.0, 40.0),
        (90.0, 40.0),
        (90.0, 60.0),
        (0, 60),
    )
    assert remaining_area(comb, legs_over(comb), 1, 0.0) == comb


@example(heading_rad=1.25, east=5.0, leg=2)
@given(heading_rad=st.floats(0.0, math.pi), east=st.floats(-10.0, 10.0), leg=st.integers(0, 2))
def test_places_of_later_legs_remain_and_those_of_earlier_ones_do_not(
    heading_rad: float, east: float, leg: int
) -> None:
    area: Polygon = ((0.0, 0.0), (80.0 + east, 5.0), (95.0, 60.0), (-5.0, 70.0 - east))
    legs = legs_over(area, heading_rad)
    rest = remaining_area(area, legs, leg, 0.0)
    assert rest is not None
    for number, one in enumerate(legs):
        middle = (np.array(one.start_enu_m) + np.array(one.end_enu_m)) / 2.0
        if contains(middle, np.array(area)):
            assert contains(middle, np.array(rest)) == (number >= leg)
