"""Ways around no-go zones: by example, and whatever the zones."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.polygon import Boundary
from aos_gcs.airspace.separation import segment_distance

MARGIN_M, SLACK_M = 2.0, 0.5
FENCE = Boundary(
    np.array([[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]]),
    "the geofence",
    keeps_in=True,
    margin_m=MARGIN_M,
)
NOTCHED = Boundary(
    np.array([[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [0.0, -10.0], [-50.0, 50.0]]),
    "the geofence",
    keeps_in=True,
    margin_m=MARGIN_M,
)


def zone(*vertices_m: tuple[float, float]) -> Boundary:
    return Boundary(np.array(vertices_m), "a zone", keeps_in=False, margin_m=MARGIN_M)


def next_corner(
    detours: Detours, start_m: NDArray[np.float64], end_m: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    (corner_m,) = detours.next_corners(start_m[None], end_m[None])
    return corner_m


def fly(detours: Detours, start_m: NDArray[np.float64], end_m: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the corners of the whole path."""
    path = [start_m]
    while (corner_m := next_corner(detours, path[-1], end_m)) is not None:
        path.append(corner_m)
        assert len(path) < 50
    return [*path, end_m]


WALL = zone((-5.0, -30.0), (5.0, -30.0), (5.0, 40.0), (-5.0, 40.0))


@pytest.mark.parametrize("clockwise", [False, True])
def test_the_shorter_path_around_a_wall_is_taken(clockwise: bool) -> None:
    wall = Boundary(WALL.vertices_m[::-1], "a wall", keeps_in=False, margin_m=MARGIN_M) if clockwise else WALL
    detours = Detours([FENCE, wall], SLACK_M)
    path = fly(detours, np.array([-20.0, 30.0]), np.array([20.0, 30.0]))
    assert np.round(path, 6).tolist() == [[-20.0, 30.0], [-8.0, 43.0], [8.0, 43.0], [20.0, 30.0]]


def test_a_clear_path_needs_no_corner() -> None:
    assert next_corner(Detours([FENCE, WALL], SLACK_M), np.array([-20.0, 0.0]), np.array([-20.0, 40.0])) is None


def test_a_wall_from_fence_to_fence_cannot_be_passed() -> None:
    wall = zone((-5.0, -60.0), (5.0, -60.0), (5.0, 60.0), (-5.0, 60.0))
    detours = Detours([FENCE, wall], SLACK_M)
    west_m, east_m = np.array([-20.0, 0.0]), np.array([20.0, 0.0])
    assert next_corner(detours, west_m, east_m) is None
    assert not detours.has_path(west_m, east_m)
    assert detours.has_path(west_m, np.array([-20.0, 40.0]))
    assert Detours([FENCE, WALL], SLACK_M).has_path(west_m, east_m)


def test_each_boundary_has_its_own_margin() -> None:
    wall = zone((-5.0, -30.0), (5.0, -30.0), (5.0, 40.0), (-5.0, 40.0))
    fence = replace(FENCE, margin_m=9.0)  # leaves 1 m between the wall and itself
    west_m, east_m = np.array([-20.0, 30.0]), np.array([20.0, 30.0])
    path = fly(Detours([fence, replace(wall, margin_m=0.2)], 0.1), west_m, east_m)
    assert np.round(path, 6).tolist() == [[-20.0, 30.0], [-5.4, 40.4], [5.4, 40.4], [20.0, 30.0]]
    assert fly(Detours([fence, wall], 0.1), west_m, east_m)[1][1] < -30.0  # 2 m and 9 m do not fit: the other way


def test_a_notch_of_the_fence_is_flown_around() -> None:
    path = fly(Detours([NOTCHED], SLACK_M), np.array([-30.0, 10.0]), np.array([30.0, 10.0]))
    assert [len(path), min(north_m for _, north_m in path) < -12.0] == [4, True]


def test_a_place_in_a_zone_is_moved_out_of_it() -> None:
    detours = Detours([FENCE, WALL], SLACK_M)
    assert detours.reachable(np.array([3.0, 0.0])) == pytest.approx([7.5, 0.0])
    assert detours.reachable(np.array([20.0, 0.0])) == pytest.approx([20.0, 0.0])


def test_who_misses_a_corner_by_the_slack_flies_on() -> None:
    detours = Detours([FENCE, WALL], SLACK_M)
    end_m = np.array([20.0, 30.0])
    for angle_rad in np.linspace(0.0, 2.0 * math.pi, 12):
        missed_m = np.array([-8.0, 43.0]) + SLACK_M * np.array([math.cos(angle_rad), math.sin(angle_rad)])
        assert next_corner(detours, missed_m, end_m) == pytest.approx([8.0, 43.0])


places = st.tuples(st.floats(-45.0, 45.0), st.floats(-45.0, 45.0)).map(np.array)
triangles = st.tuples(places, st.floats(2.0, 15.0), st.lists(st.floats(0.0, 2.0), min_size=3, max_size=3))


@settings(max_examples=60, deadline=None)
@given(st.lists(triangles, min_size=1, max_size=4), places, places)
def test_no_path_comes_nearer_to_a_boundary_than_the_margin(
    drawn: list[tuple[NDArray[np.float64], float, list[float]]],
    start_m: NDArray[np.float64],
    end_m: NDArray[np.float64],
) -> None:
    zones = [
        Boundary(
            centre_m + radius_m * np.array([[math.cos(a), math.sin(a)] for a in (t[0], 2.1 + t[1], 4.2 + t[2])]),
            "a zone",
            keeps_in=False,
            margin_m=MARGIN_M,
        )
        for centre_m, radius_m, t in drawn
    ]
    detours = Detours([FENCE, *zones], SLACK_M)
    start_m, end_m = detours.reachable(start_m), detours.reachable(end_m)
    assume(all(b.depth_m(p) >= MARGIN_M - 1e-6 for b in (FENCE, *zones) for p in (start_m, end_m)))
    path = fly(detours, start_m, end_m)
    if len(path) == 2:
        return  # Straight, or no path at all: then safety shortens it.
    for one_m, other_m in pairwise(path):
        for boundary in (FENCE, *zones):
            vertices_m = boundary.vertices_m
            gaps_m = segment_distance(one_m, other_m, vertices_m, np.roll(vertices_m, -1, axis=0))
            assert gaps_m.min() >= MARGIN_M - 1e-6
            assert boundary.depth_m(other_m) >= MARGIN_M - 1e-6


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_places_reached_are_those_that_a_path_leads_to(data: st.DataObject) -> None:
    coordinate = st.floats(-45.0, 45.0)
    notches = zone((-5.0, -60.0), (5.0, -60.0), (5.0, data.draw(st.floats(0.0, 60.0))), (-5.0, 40.0))
    detours = Detours([FENCE, notches], SLACK_M)
    start_m = detours.reachable(np.array(data.draw(st.tuples(coordinate, coordinate))))
    places_m = np.array(data.draw(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6)))
    expected = [
        bool(np.array_equal(detours.reachable(place_m), place_m)) and detours.has_path(start_m, place_m)
        for place_m in places_m
    ]
    assert detours.reached(start_m, places_m).tolist() == expected


def test_ways_that_are_looked_at_together_are_those_of_each_alone() -> None:
    detours = Detours([NOTCHED, zone((-20.0, -20.0), (-20.0, -30.0), (20.0, -30.0), (20.0, -20.0))], SLACK_M)
    starts_m, ends_m = np.random.default_rng(5).uniform(-55.0, 55.0, (2, 60, 2))
    together = detours.next_corners(starts_m, ends_m)
    alone = [next_corner(detours, start_m, end_m) for start_m, end_m in zip(starts_m, ends_m, strict=True)]
    assert [None if corner_m is None else tuple(corner_m) for corner_m in together] == [
        None if corner_m is None else tuple(corner_m) for corner_m in alone
    ]
    assert 0 < sum(corner_m is None for corner_m in together) < len(together)
