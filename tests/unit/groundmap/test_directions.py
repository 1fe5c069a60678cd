"""Squares of directions: which views of a place pass the canopy through gaps of their own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.groundmap.directions import FINEST_STEP, GAP_SHARE, MAX_TANGENT, ViewDirections, direction_step

CELL = np.zeros((1, 3))


def square(directions: ViewDirections, tangent: tuple[float, float], height_m: float = 40.0) -> int | None:
    camera = np.array([*(height_m * np.array(tangent)), height_m])
    squares, counts = directions.squares(camera, CELL)
    return int(squares[0]) if counts[0] else None


def test_the_step_is_a_share_of_the_occluders_size_by_their_height() -> None:
    assert direction_step(5.0, 18.0, 1.4) == pytest.approx(GAP_SHARE * 1.4 / 11.5)


@given(st.floats(-0.99, 0.99), st.floats(-0.99, 0.99), st.floats(10.0, 120.0), st.floats(10.0, 120.0))
def test_only_the_direction_matters_not_the_height(east: float, north: float, one_m: float, other_m: float) -> None:
    # Beside an edge, rounding decides.
    directions = ViewDirections(0.12)
    if min(abs(tangent / 0.12 - round(tangent / 0.12)) for tangent in (east, north)) > 1e-6:
        assert square(directions, (east, north), one_m) == square(directions, (east, north), other_m)


@given(st.floats(0.005, 0.6), st.floats(-0.999, 0.999), st.floats(-0.999, 0.999))
def test_every_view_has_a_square_of_its_own(step: float, east: float, north: float) -> None:
    directions = ViewDirections(step)
    index = square(directions, (east, north))
    assert index is not None
    assert 0 <= index < directions.side**2 <= 8 * directions.byte_count
    assert square(directions, (east, north)) == index


@pytest.mark.parametrize(("apart", "expected"), [(0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (1.0, 1.0), (1.7, 1.0)])
def test_views_repeat_each_other_by_the_share_of_a_shadow_that_they_have_in_common(
    apart: float, expected: float
) -> None:
    directions, rng = ViewDirections(0.12), np.random.default_rng(5)
    starts = rng.uniform(-0.5, 0.5, 4000)
    differ = [square(directions, (start, 0.0)) != square(directions, (start + 0.12 * apart, 0.0)) for start in starts]
    assert np.mean(differ) == pytest.approx(expected, abs=0.03)


def test_views_that_are_too_flat_or_from_below_do_not_count() -> None:
    directions = ViewDirections(0.12)
    assert square(directions, (MAX_TANGENT, 0.0)) is None
    assert square(directions, (0.0, 0.0), -5.0) is None
    unknown = np.array([[0.0, 0.0, np.nan]])
    assert not directions.squares(np.array([0.0, 0.0, 30.0]), unknown)[1].any()


def test_a_canopy_finer_than_the_finest_step_is_counted_with_it() -> None:
    assert ViewDirections(1e-4).side == ViewDirections(FINEST_STEP).side == 64
