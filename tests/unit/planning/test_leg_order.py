"""Order of legs: likely places first, the same ground, never later on average than to and fro."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.planning import leg_order
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.gaps import find_gap_legs
from aos_gcs.planning.leg_order import Chances, chances_of, order_legs
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.remaining import remaining_area
from aos_gcs.planning.settings import ForestSettings
from aos_gcs.prior.model import AreaPrior

HALF_M = 200.0
SQUARE = ((-HALF_M, -HALF_M), (HALF_M, -HALF_M), (HALF_M, HALF_M), (-HALF_M, HALF_M))
PLAN = MissionPlan(
    vehicles=3,
    area_enu_m=SQUARE,
    launch_enu_m=(-HALF_M, -HALF_M),
    forest=ForestSettings(18.0, 4.4, occlusion=0.84),
    line_spacing_m=25.0,
    leg_spacing_m=80.0,
)
START = (-HALF_M, -HALF_M)
LEGS = planned_legs(PLAN, 0.0)
CELL_M = 10.0


def prior_at(east_m: float, north_m: float, radius_m: float, background: float = 0.0) -> AreaPrior:
    """A prior that is even within a circle, and has a share spread over the rest."""
    count = int(2 * HALF_M / CELL_M)
    rows, columns = np.mgrid[:count, :count]
    east, north = -HALF_M + (columns + 0.5) * CELL_M, HALF_M - (rows + 0.5) * CELL_M
    inside = np.hypot(east - east_m, north - north_m) <= radius_m
    mass = np.where(inside, (1.0 - background) / max(1, inside.sum()), 0.0) + background / count**2
    return AreaPrior(-HALF_M, HALF_M, CELL_M, mass)


def prior_in_the_east(background: float) -> AreaPrior:
    """A prior that is even in the eastern strip, and has a share spread over the rest."""
    count = int(2 * HALF_M / CELL_M)
    mass = np.full((count, count), background / (count * (count - 8)))
    mass[:, -8:] = (1.0 - background) / (count * 8)
    return AreaPrior(-HALF_M, HALF_M, CELL_M, mass)


def ordered(prior: AreaPrior | None, plan: MissionPlan = PLAN, raster: ViewRaster | None = None) -> tuple[ScanLeg, ...]:
    return order_legs(LEGS, plan, chances_of(plan, 0.0, prior, raster), START)


def covered(legs: tuple[ScanLeg, ...]) -> list[tuple[int, int]]:
    """Metres of strips that legs cover: strip and metre."""
    found = []
    for leg in legs:
        ends = sorted((leg.start_enu_m[1], leg.end_enu_m[1]))
        found += [(round(leg.start_enu_m[0]), metre) for metre in range(round(ends[0]), round(ends[1]))]
    return sorted(found)


def mean_time_s(legs: tuple[ScanLeg, ...], plan: MissionPlan, chances: Chances) -> float:
    """Mean time until the person is noticed; who is not noticed counts with the end of the legs."""
    bin_m, width_m = leg_order._BIN_M, leg_order.strip_width_m(plan, LEGS)
    strips = [leg_order._strip(leg, width_m, chances, bin_m) for leg in legs]
    parts = [leg_order._Part(number, 0, strip.bins, is_back=False) for number, strip in enumerate(strips)]
    pace = leg_order._Pace(plan.cruise_speed_mps, leg_order._leg_mps(plan), bin_m)
    return leg_order._mean_time_s(parts, strips, START, pace)


def test_without_a_prior_a_square_is_flown_to_and_fro() -> None:
    assert ordered(None) == LEGS
    assert ordered(None, replace(PLAN, forest=None)) == LEGS


def test_the_likely_strip_is_flown_first() -> None:
    for background in (0.1, 0.0):
        legs = ordered(prior_in_the_east(background))
        assert legs[0].start_enu_m[0] == pytest.approx(160.0)
        assert covered(legs) == covered(LEGS)


def test_the_likely_part_of_long_legs_is_flown_first() -> None:
    long = replace(PLAN, search_speed_mps=1.0)
    prior = prior_at(0.0, 120.0, 50.0, background=0.05)
    legs = order_legs(LEGS, long, chances_of(long, 0.0, prior), START)
    first = legs[0]
    assert first.length_m < 250.0
    assert min(first.start_enu_m[1], first.end_enu_m[1]) > -50.0
    assert max(first.start_enu_m[1], first.end_enu_m[1]) > 120.0
    assert covered(legs) == covered(LEGS)


def test_what_was_searched_before_is_flown_last() -> None:
    views = np.zeros((400, 400), dtype=np.uint8)
    views[:, :240] = 60  # the three western strips
    legs = ordered(None, raster=ViewRaster(-200, -200, views))
    assert [round(leg.start_enu_m[0]) for leg in legs[:2]] in ([80, 160], [160, 80])
    assert covered(legs) == covered(LEGS)


def test_zones_have_no_chances() -> None:
    zone = ((100.0, -200.0), (200.0, -200.0), (200.0, 200.0), (100.0, 200.0))
    plan = replace(PLAN, no_go_enu_m=(zone,))
    chances = chances_of(plan, 0.0, prior_in_the_east(background=0.1))
    assert chances.places_m[:, 0].max() < 100.0
    assert ordered(prior_in_the_east(background=0.1), plan)[0].start_enu_m[0] < 100.0


@settings(max_examples=12, deadline=None)
@given(
    east_m=st.floats(-200.0, 200.0),
    north_m=st.floats(-200.0, 200.0),
    radius_m=st.floats(10.0, 300.0),
    background=st.sampled_from([0.0, 0.1, 0.5]),
    speed_mps=st.sampled_from([1.0, 5.0, 10.0]),
)
def test_no_order_notices_later_than_to_and_fro_or_leaves_ground_out(
    east_m: float, north_m: float, radius_m: float, background: float, speed_mps: float
) -> None:
    plan = replace(PLAN, search_speed_mps=speed_mps, forest=None)
    chances = chances_of(plan, 0.0, prior_at(east_m, north_m, radius_m, background))
    legs = order_legs(LEGS, plan, chances, START)
    assert legs == order_legs(LEGS, plan, chances, START)
    assert covered(legs) == covered(LEGS)
    plain_s, own_s = (mean_time_s(one, plan, chances) for one in (LEGS, legs))
    assert own_s <= plain_s * (1.0 + 1e-6)
    assert legs == LEGS or own_s < 0.99 * plain_s


def test_what_is_left_of_legs_in_another_order_holds_all_that_were_not_flown() -> None:
    legs = ordered(prior_in_the_east(background=0.1))
    assert remaining_area(SQUARE, legs, 0, 50.0) == SQUARE
    rest = remaining_area(SQUARE, legs, 1, 0.0)
    assert rest is not None
    assert max(corner[0] for corner in rest) == pytest.approx(120.0), "the eastern strip is flown"
    assert min(corner[0] for corner in rest) == -HALF_M
    assert remaining_area(SQUARE, legs, len(legs), 0.0) is None
    assert remaining_area(SQUARE, legs, len(legs) - 1, legs[-1].length_m - 1.0) is None


def test_gaps_are_flown_again_where_the_person_is_likely() -> None:
    raster = ViewRaster(-200, -200, np.full((400, 400), 4, dtype=np.uint8))

    def first(prior: AreaPrior | None) -> ScanLeg:
        found = find_gap_legs(raster, PLAN, 0.0, from_m=(0.0, 0.0), within_s=300.0, pod=0.95, prior=prior)
        assert found is not None
        return found.legs[0]

    leg = first(prior_at(150.0, -150.0, 45.0))
    assert np.hypot(*(np.add(leg.start_enu_m, leg.end_enu_m) / 2.0 - (150.0, -150.0))) < 80.0
    assert leg.length_m < 200.0 < first(None).length_m
