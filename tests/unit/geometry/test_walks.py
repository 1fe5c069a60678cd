"""Ways of simulated persons."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.walks import Walk


def test_a_person_walks_to_and_fro() -> None:
    walk = Walk(speed_mps=2.0, length_m=8.0, heading_rad=math.pi / 2)
    places = {0.0: 0.0, 1.0: 2.0, 3.0: 2.0, 4.0: 0.0, 6.0: -4.0, 8.0: 0.0}
    for at_s, east_m in places.items():
        (east, north), _ = walk.at(at_s)
        assert (east, north) == pytest.approx((east_m, 0.0), abs=1e-9)
    assert [round(math.degrees(walk.at(at_s)[1])) for at_s in (1.0, 3.0, 7.0)] == [90, 270, 90]


@given(st.floats(0.1, 5.0), st.floats(0.0, 1e5), st.floats(0.0, 10.0), st.floats(-4.0, 4.0))
def test_it_stays_on_its_line_and_keeps_its_speed(
    speed_mps: float, at_s: float, later_s: float, heading_rad: float
) -> None:
    walk = Walk(speed_mps, 8.0, heading_rad)
    (first_m, _), (then_m, _) = walk.at(at_s), walk.at(at_s + later_s)
    assert math.hypot(*first_m) <= 4.0 + 1e-6
    assert math.dist(first_m, then_m) <= speed_mps * later_s + 1e-6
