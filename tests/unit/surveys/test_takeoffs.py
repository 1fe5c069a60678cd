"""Takeoffs of the flights in one folder."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.heights import AmslM
from aos_gcs.surveys.takeoffs import TakeoffSite, group_takeoffs


def takeoffs(*altitudes_m: float | None) -> tuple[TakeoffSite, ...]:
    return group_takeoffs([None if altitude_m is None else AmslM(altitude_m) for altitude_m in altitudes_m])


def test_flights_from_different_heights_are_told_apart() -> None:
    low, high = takeoffs(600.1, 599.8, 600.0, 600.3, 625.2, 624.9, 625.0)
    assert (low.altitude_amsl_m, low.photographs) == (pytest.approx(600.05), (0, 1, 2, 3))
    assert (high.altitude_amsl_m, high.photographs) == (625.0, (4, 5, 6))


def test_flights_may_take_turns() -> None:
    """Two aircraft whose photographs are in the order of their times."""
    assert [one.photographs for one in takeoffs(600, 640, 600, 640, 600, 640)] == [(0, 2, 4), (1, 3, 5)]


def test_a_drift_is_one_flight() -> None:
    drift_m = 600.0 + np.random.default_rng(0).normal(0.0, 1.0, 50) + np.linspace(0.0, 15.0, 50)
    (takeoff,) = takeoffs(*drift_m)
    assert takeoff.altitude_amsl_m == pytest.approx(np.median(drift_m))
    assert takeoff.strays == ()


@pytest.mark.parametrize("at", [0, 3, 6])
def test_an_altitude_that_one_photograph_alone_tells_is_an_error(at: int) -> None:
    altitudes_m = [600.0] * 7
    altitudes_m[at] = 680.0
    assert takeoffs(*altitudes_m) == (TakeoffSite(AmslM(600.0), tuple(range(7)), (at,)),)


def test_a_few_photographs_are_their_own_takeoffs() -> None:
    assert [one.altitude_amsl_m for one in takeoffs(600.0, 625.0)] == [600.0, 625.0]


def test_photographs_without_an_altitude_belong_to_those_beside_them() -> None:
    low, high = takeoffs(None, 600, 600, 600, None, None, 640, 640, 640)
    assert (low.photographs, high.photographs) == ((0, 1, 2, 3, 4), (5, 6, 7, 8))
    assert takeoffs(None, None) == ()


@given(st.lists(st.none() | st.floats(-400.0, 9000.0), max_size=12))
def test_each_photograph_has_one_takeoff(altitudes_m: list[float | None]) -> None:
    found = takeoffs(*altitudes_m)
    indices = sorted(index for takeoff in found for index in takeoff.photographs)
    assert indices == (list(range(len(altitudes_m))) if found else [])
    assert bool(found) == any(altitude_m is not None for altitude_m in altitudes_m)
