import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from aos_gcs.imaging.connected import connected, within_disc, within_square

cells = st.sets(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=1, max_size=60)


def by_scipy(places: np.ndarray, reach: float, norm: float) -> np.ndarray:
    pairs = cKDTree(places).query_pairs(reach, p=norm, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places), len(places)))
    return connected_components(graph, directed=False)[1]


@given(cells, st.sampled_from([1.0, 1.5, 2.0, 2.5, 6.0]))
@example({(0, 0), (0, 5), (1, -5)}, 6.0)
def test_cells_within_a_distance_belong_together(places: set[tuple[int, int]], radius: float) -> None:
    rows_columns = np.array(sorted(places, key=hash))
    found = connected(rows_columns[:, 0], rows_columns[:, 1], within_disc(radius))
    assert found.tolist() == by_scipy(rows_columns, radius, 2.0).tolist()


@given(cells, st.integers(1, 4))
def test_cells_within_a_square_belong_together(places: set[tuple[int, int]], reach: int) -> None:
    rows_columns = np.array(sorted(places, key=hash))
    found = connected(rows_columns[:, 0], rows_columns[:, 1], within_square(reach))
    assert found.tolist() == by_scipy(rows_columns, reach, math.inf).tolist()


@pytest.mark.parametrize("order", [1, -1])
def test_a_long_winding_line_is_one_set(order: int) -> None:
    angle_rad = np.linspace(0.0, 12.0 * math.pi, 9000)
    places = np.unique(np.rint(np.column_stack((np.cos(angle_rad), np.sin(angle_rad))).T * 5.0 * angle_rad).T, axis=0)
    rows, columns = places[::order].astype(np.intp).T
    assert connected(rows, columns, within_square(1)).max() == 0


def test_cells_near_the_horizon_are_sets_of_their_own() -> None:
    rows, columns = np.array([0.0, 1e18, 1.0, 1e18]), np.array([0.0, 1e18, 1.0, -1e18])
    assert connected(rows, columns, within_square(1)).tolist() == [0, 1, 0, 2]
