import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aos_gcs.imaging.connected import connected

cells = st.sets(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=1, max_size=60)


def by_flooding(places: np.ndarray, reach: float) -> list[int]:
    labels = [-1] * len(places)
    near = np.linalg.norm(places[:, np.newaxis] - places[np.newaxis], axis=-1) <= reach
    for first in range(len(places)):
        reached = [first] if labels[first] < 0 else []
        label = max(labels) + 1
        while reached:
            here = reached.pop()
            labels[here] = label
            reached += [int(one) for one in np.flatnonzero(near[here]) if labels[one] < 0]
    return labels


@given(cells, st.sampled_from([1.0, 1.5, 2.0, 2.5, 6.0]))
@example({(0, 0), (0, 5), (1, -5)}, 6.0)
def test_cells_within_a_distance_belong_together(places: set[tuple[int, int]], radius: float) -> None:
    rows_columns = np.array(sorted(places, key=hash))
    found = connected(rows_columns[:, 0], rows_columns[:, 1], radius)
    assert found.tolist() == by_flooding(rows_columns, radius)


@pytest.mark.parametrize("order", [1, -1])
def test_a_long_winding_line_is_one_set(order: int) -> None:
    angle_rad = np.linspace(0.0, 12.0 * math.pi, 9000)
    places = np.unique(np.rint(np.column_stack((np.cos(angle_rad), np.sin(angle_rad))).T * 5.0 * angle_rad).T, axis=0)
    rows, columns = places[::order].astype(np.intp).T
    assert connected(rows, columns, 1.5).max() == 0


def test_cells_near_the_horizon_are_sets_of_their_own() -> None:
    rows, columns = np.array([0.0, 1e18, 1.0, 1e18]), np.array([0.0, 1e18, 1.0, -1e18])
    assert connected(rows, columns, 1.5).tolist() == [0, 1, 0, 2]
