"""Layers staggered by launch points: nobody descends onto the way home of another."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from aos_gcs.airspace.separation import segment_distance
from aos_gcs.planning.descents import meetings, passes, staggered

AREA_ENU_M = ((-20.0, 40.0), (20.0, 40.0), (20.0, 90.0), (-20.0, 90.0))
CLEARANCE_M = 1.6


def layers_of(homes_m: np.ndarray) -> np.ndarray:
    layers_m = 35.0 + 2.0 * np.arange(len(homes_m))
    return np.array(staggered(passes(AREA_ENU_M, homes_m, CLEARANCE_M), layers_m.tolist()))


def test_side_by_side_the_layers_stay_in_order() -> None:
    homes_m = np.array([[5.0 * i, 0.0] for i in range(-2, 3)])
    assert layers_of(homes_m).tolist() == [35.0, 37.0, 39.0, 41.0, 43.0]


def test_one_behind_another_the_front_one_is_lowest() -> None:
    homes_m = np.array([[0.0, -10.0], [0.0, -5.0], [0.0, 0.0]])
    assert layers_of(homes_m).tolist() == [39.0, 37.0, 35.0]
    is_past = passes(AREA_ENU_M, homes_m, CLEARANCE_M)
    assert meetings(is_past, [35.0, 37.0, 39.0]) == [(0, 1), (0, 2), (1, 2)]
    assert meetings(is_past, layers_of(homes_m).tolist()) == []


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 8))
def test_without_meetings_every_way_home_keeps_clear_of_every_descent(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    homes_m = rng.uniform([-15.0, -25.0], [15.0, 5.0], (count, 2))
    gaps_m = np.linalg.norm(homes_m[:, None] - homes_m, axis=2) + 99.0 * np.eye(count)
    assume(gaps_m.min() > 2.0)
    layers_m = layers_of(homes_m)
    unsolved = set(meetings(passes(AREA_ENU_M, homes_m, CLEARANCE_M), layers_m.tolist()))
    starts_m = rng.uniform([-20.0, 40.0], [20.0, 90.0], (count, 2))
    for one in range(count):
        for other in set(range(count)) - {one}:
            if (one, other) in unsolved:
                continue
            way = np.array([[*starts_m[one], layers_m[one]], [*homes_m[one], layers_m[one]]])
            descent = np.array([[*homes_m[other], layers_m[other]], [*homes_m[other], 0.0]])
            assert float(segment_distance(way[0], way[1], descent[0], descent[1])) >= 1.5
