"""Altitude layers, scan legs and fences of a plan."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import as_polygon, contains, signed_area_m2, signed_depth_m
from aos_gcs.airspace.separation import point_segment_distance
from aos_gcs.errors import ConfigurationError
from aos_gcs.planning.legs import PASSES_APART_M, ScanLeg, in_passes, leg_formation, scan_legs
from aos_gcs.planning.proposal import altitude_layers, propose_fence

FloatArray = NDArray[np.float64]
SQUARE = ((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0))
NORTH = np.array([0.0, 1.0])


def legs_of(
    area: tuple[tuple[float, float], ...], start: FloatArray, direction: FloatArray = NORTH
) -> tuple[ScanLeg, ...]:
    """A swath of 9 * 4 + 14 = 50 m."""
    return scan_legs(area, start, direction, n=10, spacing_m=4.0, footprint_m=14.0)


def test_layers() -> None:
    assert altitude_layers(3, 35.0, 2.0) == (35.0, 37.0, 39.0)


def test_two_legs_to_and_fro_from_the_corner_next_to_the_start() -> None:
    first, second = legs_of(SQUARE, np.array([90.0, -20.0]))
    assert (first.start_enu_m, first.length_m) == (pytest.approx((75.0, 0.0)), pytest.approx(100.0))
    assert first.direction_enu == pytest.approx((0.0, 1.0))
    assert (second.start_enu_m, second.end_enu_m) == (pytest.approx((25.0, 100.0)), pytest.approx((25.0, 0.0)))


def test_the_second_pass_flies_back_beside_the_first_and_the_third_there_again() -> None:
    legs = legs_of(SQUARE, np.array([90.0, -20.0]))
    assert in_passes(legs, 1) == legs
    flown = in_passes(legs, 3)
    starts_m = [leg.start_enu_m for leg in flown]
    assert starts_m[2] == pytest.approx((25.0 + PASSES_APART_M, 0.0)), "where the first pass has ended"
    assert flown[3].end_enu_m == pytest.approx((75.0 - PASSES_APART_M, 0.0))
    assert starts_m[4] == pytest.approx((75.0 + 2.0 * PASSES_APART_M, 0.0))
    assert [leg.direction_enu[1] for leg in flown] == pytest.approx([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    assert len({round(leg.start_enu_m[0], 3) for leg in flown}) == 6, "no track twice"


def test_the_direction_is_an_axis_and_the_start_decides_the_direction() -> None:
    (first, _) = legs_of(SQUARE, np.array([10.0, 150.0]))
    assert first.start_enu_m == pytest.approx((25.0, 100.0))
    assert first.direction_enu == pytest.approx((0.0, -1.0))


def test_one_leg_along_the_middle_when_a_swath_is_wide_enough() -> None:
    (leg,) = legs_of(((0.0, 0.0), (50.0, 0.0), (50.0, 80.0), (0.0, 80.0)), np.array([0.0, -5.0]))
    assert (leg.start_enu_m, leg.end_enu_m) == (pytest.approx((25.0, 0.0)), pytest.approx((25.0, 80.0)))


def test_legs_are_as_long_as_the_area_is_in_their_strip() -> None:
    triangle = ((0.0, 0.0), (100.0, 0.0), (0.0, 100.0))
    first, second = legs_of(triangle, np.array([0.0, -1.0]))
    assert (first.length_m, second.length_m) == (pytest.approx(100.0), pytest.approx(50.0))
    assert second.end_enu_m == pytest.approx((75.0, 0.0))


@st.composite
def star_polygons(draw: st.DrawFn) -> tuple[tuple[float, float], ...]:
    """Simple polygons, most of them not convex: radii about a centre at ascending angles."""
    radii = draw(st.lists(st.floats(10.0, 120.0), min_size=4, max_size=10))
    angles = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    return tuple((float(r * np.cos(angle)), float(r * np.sin(angle))) for r, angle in zip(radii, angles, strict=True))


@settings(max_examples=60, deadline=None)
@given(
    star_polygons(),
    st.floats(-np.pi, np.pi),
    st.tuples(st.floats(-200.0, 200.0), st.floats(-200.0, 200.0)),
    st.lists(st.tuples(st.floats(-120.0, 120.0), st.floats(-120.0, 120.0)), min_size=30, max_size=30),
)
def test_every_point_of_the_area_is_within_half_a_swath_of_a_leg(
    area: tuple[tuple[float, float], ...],
    angle: float,
    start: tuple[float, float],
    samples: list[tuple[float, float]],
) -> None:
    legs = legs_of(area, np.array(start), np.array([np.cos(angle), np.sin(angle)]))
    starts = np.array([leg.start_enu_m for leg in legs])
    ends = np.array([leg.end_enu_m for leg in legs])
    inside = [np.array(point) for point in samples if contains(np.array(point), as_polygon(area, "area"))]
    for point in [*inside, *np.array(area)]:
        assert point_segment_distance(point, starts, ends)[0].min() <= 25.0 + 1e-6


@settings(max_examples=40, deadline=None)
@given(star_polygons(), st.floats(-np.pi, np.pi), st.tuples(st.floats(-200.0, 200.0), st.floats(-200.0, 200.0)))
def test_the_pattern_begins_at_its_corner_nearest_to_the_start(
    area: tuple[tuple[float, float], ...], angle: float, start: tuple[float, float]
) -> None:
    legs = legs_of(area, np.array(start), np.array([np.cos(angle), np.sin(angle)]))
    corners = [legs[0].start_enu_m, legs[0].end_enu_m, legs[-1].start_enu_m, legs[-1].end_enu_m]
    assert math.dist(corners[0], start) <= min(math.dist(corner, start) for corner in corners) + 1e-6
    signs = [np.sign(np.dot(leg.direction_enu, legs[0].direction_enu)) for leg in legs]
    assert signs == [(-1.0) ** row for row in range(len(legs))]


def test_formation_at_the_start_of_a_leg_crosses_no_paths() -> None:
    leg = ScanLeg((50.0, 0.0), (0.0, 1.0), 100.0)
    places = leg_formation(leg, np.array([[9.0, -9.0], [0.0, -9.0], [5.0, -8.0]]), 4.0)
    assert places == pytest.approx(np.array([[54.0, 0.0], [46.0, 0.0], [50.0, 0.0]]))


@settings(max_examples=50, deadline=None)
@given(
    star_polygons(),
    st.lists(st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0)), max_size=4),
    st.floats(0.5, 60.0),
)
def test_the_fence_keeps_its_margin_and_is_convex(
    area: tuple[tuple[float, float], ...], homes: list[tuple[float, float]], margin: float
) -> None:
    assume(abs(signed_area_m2(np.array(area))) > 1.0)
    fence = as_polygon(propose_fence(area, homes, margin), "fence")
    for point in np.array([*area, *homes]):
        assert signed_depth_m(point, fence) >= margin - 1e-6
    before, after = fence - np.roll(fence, 1, axis=0), np.roll(fence, -1, axis=0) - fence
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    assert (turns > 0.0).all()


def test_polygons_drop_repeated_points() -> None:
    assert len(as_polygon([*SQUARE, SQUARE[0]], "area")) == 4
    assert len(as_polygon([SQUARE[0], *SQUARE], "area")) == 4


@pytest.mark.parametrize(
    "area",
    [
        [(0.0, 0.0), (1.0, 1.0)],
        [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)],
        [(0.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 10.0)],
        [(0.0, 0.0), (math.inf, 0.0), (1.0, 1.0)],
        [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0)],
    ],
    ids=["two points", "no area", "crossing", "infinite", "three coordinates"],
)
def test_areas_that_are_no_polygon_are_refused(area: list[tuple[float, ...]]) -> None:
    with pytest.raises(ConfigurationError, match="area_enu_m"):
        scan_legs(area, np.zeros(2), NORTH, n=10, spacing_m=4.0, footprint_m=14.0)


@pytest.mark.parametrize(
    ("change", "text"),
    [({"n": 0}, "n must"), ({"spacing_m": 0.0}, "spacing_m"), ({"footprint_m": math.nan}, "footprint_m")],
)
def test_numbers_out_of_range_are_refused(change: dict[str, float], text: str) -> None:
    values = {"n": 10, "spacing_m": 4.0, "footprint_m": 14.0}
    with pytest.raises(ConfigurationError, match=text):
        scan_legs(SQUARE, np.zeros(2), NORTH, **{**values, **change})  # type: ignore[arg-type]


def test_other_refusals_name_their_field() -> None:
    with pytest.raises(ConfigurationError, match="direction_enu"):
        legs_of(SQUARE, np.zeros(2), np.zeros(2))
    with pytest.raises(ConfigurationError, match="margin_m"):
        propose_fence(SQUARE, [], 0.0)
    with pytest.raises(ConfigurationError, match="ground_enu_m"):
        propose_fence(SQUARE, [(math.nan, 0.0)], 1.0)
    with pytest.raises(ConfigurationError, match="n must"):
        altitude_layers(0, 35.0, 1.0)
    with pytest.raises(ConfigurationError, match="lowest_m"):
        altitude_layers(3, 0.0, 1.0)
