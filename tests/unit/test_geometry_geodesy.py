"""Many places at once are the same places as one by one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame

METRES = st.floats(-5000.0, 5000.0)


@given(st.lists(st.tuples(METRES, METRES, st.floats(-100.0, 500.0)), max_size=5), st.floats(-80.0, 80.0))
def test_places_are_converted_together_as_alone_and_come_back(
    points_enu_m: list[tuple[float, float, float]], latitude_deg: float
) -> None:
    frame = LocalFrame(GeodeticPosition(latitude_deg, 14.3, 260.0))
    together = frame.to_geodetic_all(points_enu_m)
    assert together == [frame.to_geodetic(point_enu_m) for point_enu_m in points_enu_m]
    for point_enu_m, position in zip(points_enu_m, together, strict=True):
        assert frame.to_enu(position) == pytest.approx(point_enu_m, abs=1e-3)
