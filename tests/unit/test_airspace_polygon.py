import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from aos_gcs.airspace.polygon import convex_hull, signed_area_m2

coordinates = st.integers(-6, 6) | st.floats(-100.0, 100.0)
clouds = st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=30).map(np.array)


@given(clouds)
def test_the_hull_of_points_is_the_smallest_convex_polygon_around_them(points_m: np.ndarray) -> None:
    assume(np.linalg.matrix_rank(points_m[1:] - points_m[0], tol=1e-3) == 2)
    hull_m = convex_hull(points_m)
    assert signed_area_m2(hull_m) == pytest.approx(ConvexHull(points_m).volume, rel=1e-9, abs=1e-9)
    edges_m = np.roll(hull_m, -1, axis=0) - hull_m
    offsets_m = points_m[:, None] - hull_m
    assert (edges_m[:, 0] * offsets_m[..., 1] - edges_m[:, 1] * offsets_m[..., 0] > -1e-6).all()


def test_points_along_the_edge_are_no_corners() -> None:
    points_m = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [1.0, 1.0], [4.0, 4.0]])
    assert convex_hull(points_m).tolist() == [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]
