"""The scanning line: places, orders, and that projection order is the best assignment without crossings."""

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from aos_gcs.swarm.line import line_axis, line_by_index, line_by_projection, line_places, unit_vector

FloatArray = NDArray[np.float64]


def positions(min_n: int, max_n: int) -> st.SearchStrategy[FloatArray]:
    coordinate = st.floats(-50.0, 50.0)
    return st.integers(min_n, max_n).flatmap(lambda n: arrays(np.float64, (n, 2), elements=coordinate))


directions = st.floats(-np.pi, np.pi).map(lambda angle: np.array([np.cos(angle), np.sin(angle)]))


def test_places_of_three_drones_that_scan_northwards() -> None:
    places = line_places(np.array([10.0, 20.0]), np.array([0.0, 2.0]), 3, 4.0)
    assert places == pytest.approx(np.array([[14.0, 20.0], [10.0, 20.0], [6.0, 20.0]]))


def test_index_order_keeps_the_rows_and_projection_order_does_not() -> None:
    drones = np.array([[-4.0, 1.0], [4.0, -1.0]])
    north = np.array([0.0, 1.0])
    assert line_by_index(drones, north, 6.0) == pytest.approx(np.array([[3.0, 0.0], [-3.0, 0.0]]))
    assert line_by_projection(drones, north, 6.0) == pytest.approx(np.array([[-3.0, 0.0], [3.0, 0.0]]))


@given(positions(1, 12), directions)
def test_line_is_centred_perpendicular_and_evenly_spaced(drones: FloatArray, direction: FloatArray) -> None:
    places = line_by_index(drones, direction, 4.2)
    assert places.mean(axis=0) == pytest.approx(drones.mean(axis=0), abs=1e-9)
    assert (places - places[0]) @ direction == pytest.approx(np.zeros(len(drones)), abs=1e-9)
    assert np.diff(places @ line_axis(direction)) == pytest.approx(np.full(len(drones) - 1, 4.2))


@settings(max_examples=60, deadline=None)
@given(positions(2, 6), directions)
def test_projection_order_has_the_least_sum_of_squares(drones: FloatArray, direction: FloatArray) -> None:
    places = line_by_projection(drones, direction, 4.2)
    cost = ((places - drones) ** 2).sum()
    best = min(((places[list(order)] - drones) ** 2).sum() for order in permutations(range(len(drones))))
    assert cost <= best + 1e-7 * max(1.0, best)


@settings(max_examples=60, deadline=None)
@given(positions(2, 10), directions)
def test_no_two_drones_cross_on_their_way_into_the_line(drones: FloatArray, direction: FloatArray) -> None:
    places = line_by_projection(drones, direction, 4.2)
    axis = line_axis(direction)
    for i, j in combinations(range(len(drones)), 2):
        before, after = (drones[i] - drones[j]) @ axis, (places[i] - places[j]) @ axis
        # Along the axis the pair never changes sides, so the straight ways cannot meet inside.
        assert before * after >= -1e-9


@pytest.mark.parametrize("direction", [[0.0, 0.0], [np.nan, 1.0], [1.0, 0.0, 0.0]])
def test_a_direction_without_length_is_refused(direction: list[float]) -> None:
    with pytest.raises(ValueError, match="direction"):
        unit_vector(np.array(direction))
