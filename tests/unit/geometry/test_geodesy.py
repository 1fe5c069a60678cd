"""Geodetic positions of points in the local frame."""

from __future__ import annotations

from dataclasses import astuple

import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame

METRES = st.floats(-5000.0, 5000.0)


@given(st.tuples(METRES, METRES, st.floats(-100.0, 5000.0)), st.floats(-85.0, 85.0), st.floats(-180.0, 180.0))
def test_positions_are_those_of_pymap3d_and_lead_back(
    point_enu_m: tuple[float, float, float], latitude_deg: float, longitude_deg: float
) -> None:
    origin = GeodeticPosition(latitude_deg, longitude_deg, 260.0)
    position = LocalFrame(origin).to_geodetic(point_enu_m)
    expected = pymap3d.enu2geodetic(*point_enu_m, *astuple(origin))
    assert astuple(position) == pytest.approx(tuple(map(float, expected)), rel=0.0, abs=1e-7)
    assert LocalFrame(origin).to_enu(position) == pytest.approx(point_enu_m, abs=1e-6)


@pytest.mark.parametrize("latitude_deg", [-90.0, 0.0, 90.0])
def test_the_origin_is_itself_at_the_poles_and_on_the_equator(latitude_deg: float) -> None:
    origin = GeodeticPosition(latitude_deg, 14.3, 260.0)
    assert astuple(LocalFrame(origin).to_geodetic((0.0, 0.0, 0.0))) == pytest.approx(astuple(origin), abs=1e-7)
