"""Distances between segments against brute force; the smallest distance; moving apart."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from aos_gcs.airspace.separation import (
    admissible_fraction,
    closest_approach,
    minimum_separation,
    near_pairs,
    segment_distance,
)
from aos_gcs.airspace.spacing import spread_apart

FloatArray = NDArray[np.float64]
segments = arrays(np.float64, (4, 3), elements=st.floats(-20.0, 20.0))


@pytest.mark.parametrize(
    ("a0", "a1", "b0", "b1", "expected"),
    [
        ([0, 0, 0], [10, 0, 0], [5, -5, 3], [5, 5, 3], 3.0),
        ([0, 0, 0], [10, 0, 0], [0, 4, 0], [10, 4, 0], 4.0),
        ([0, 0, 0], [10, 0, 0], [13, 4, 0], [20, 4, 0], 5.0),
        ([0, 0, 0], [0, 0, 0], [3, 4, 0], [3, 4, 0], 5.0),
        ([0, 0, 0], [10, 0, 0], [5, 0, 0], [5, 0, 0], 0.0),
        ([0, 0, 0], [10, 10, 0], [0, 10, 0], [10, 0, 0], 0.0),
    ],
    ids=["skew", "parallel", "collinear ends", "points", "point on it", "crossing"],
)
def test_known_distances(a0: list[float], a1: list[float], b0: list[float], b1: list[float], expected: float) -> None:
    ends = [np.array(end, dtype=np.float64) for end in (a0, a1, b0, b1)]
    assert float(segment_distance(*ends)) == pytest.approx(expected)


@settings(max_examples=80, deadline=None)
@given(arrays(np.float64, (4, 6, 2), elements=st.floats(-20.0, 20.0)), st.floats(0.0, 5.0))
def test_pairs_of_segments_that_are_near_are_never_passed_over(ends: FloatArray, reach_m: float) -> None:
    a0, a1, b0, b1 = ends
    kept = set(zip(*near_pairs(a0, a1, b0, b1, reach_m), strict=True))
    distances_m = segment_distance(a0[:, None], a1[:, None], b0, b1)
    assert set(zip(*np.nonzero(distances_m < reach_m - 1e-9), strict=True)) <= kept


def test_segments_far_apart_or_beside_one_another_are_no_near_pairs() -> None:
    a0, a1 = np.array([[0.0, 0.0]]), np.array([[10.0, 10.0]])
    b0 = np.array([[20.0, 0.0], [6.0, 0.0], [0.0, 10.0]])
    b1 = np.array([[30.0, 0.0], [10.0, 4.0], [10.0, 0.0]])
    assert [rows.tolist() for rows in near_pairs(a0, a1, b0, b1, 1.0)] == [[0], [2]]


@settings(max_examples=80, deadline=None)
@given(segments)
@example(np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 1e-9, 0.0], [0.0, 0.0, 0.0]]))
def test_distance_agrees_with_sampling(ends: FloatArray) -> None:
    a0, a1, b0, b1 = ends
    fraction = np.linspace(0.0, 1.0, 81)[:, None]
    one, other = a0 + fraction * (a1 - a0), b0 + fraction * (b1 - b0)
    sampled = np.linalg.norm(one[:, None] - other[None, :], axis=2).min()
    distance, where = closest_approach(a0, a1, b0, b1)
    spacing = (np.linalg.norm(a1 - a0) + np.linalg.norm(b1 - b0)) / 80
    assert sampled - spacing <= distance <= sampled + 1e-9
    assert 0.0 <= where <= 1.0
    assert distance == pytest.approx(float(segment_distance(b0, b1, a0, a1)), abs=1e-6)


@settings(max_examples=80, deadline=None)
@given(segments, st.floats(0.1, 5.0))
def test_the_admissible_part_is_clear_and_the_largest(ends: FloatArray, required: float) -> None:
    start, end, b0, b1 = ends
    required = min(required, float(segment_distance(start, start, b0, b1)))
    fraction = admissible_fraction(start, end, b0[None], b1[None], np.array([required]))[0]
    stop = start + fraction * (end - start)
    assert float(segment_distance(start, stop, b0, b1)) >= required - 1e-6
    if fraction < 1.0:
        beyond = start + min(1.0, fraction + 1e-3) * (end - start)
        assert float(segment_distance(start, beyond, b0, b1)) < required


def test_broadcasts_over_pairs() -> None:
    b = np.array([[0.0, 1.0], [0.0, 2.0], [0.0, 3.0]])
    assert segment_distance(np.zeros(2), np.array([1.0, 0.0]), b, b) == pytest.approx([1.0, 2.0, 3.0])


def test_smallest_distance_and_its_pair() -> None:
    positions = np.array([[0.0, 0.0, 30.0], [10.0, 0.0, 30.0], [10.0, 0.0, 33.0], [0.0, 8.0, 30.0]])
    assert minimum_separation(positions) == (3.0, (1, 2))
    with pytest.raises(ValueError, match="two or more"):
        minimum_separation(positions[:1])


@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 20).flatmap(lambda n: arrays(np.float64, (n, 3), elements=st.floats(-6.0, 6.0))), st.floats(0.5, 5.0)
)
@example(np.zeros((20, 3)), 3.0)
def test_spreading_reaches_the_distance_sideways(positions: FloatArray, separation: float) -> None:
    before = positions.copy()
    apart = spread_apart(positions, separation)
    assert np.array_equal(positions, before)
    assert np.array_equal(apart[:, 2], positions[:, 2])
    if len(apart) > 1:
        assert minimum_separation(apart[:, :2])[0] >= separation
    assert np.array_equal(spread_apart(apart, separation), apart)
    assert apart[:, :2].mean(axis=0) == pytest.approx(positions[:, :2].mean(axis=0), abs=1e-6)
