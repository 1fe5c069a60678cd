"""Whether a vehicle flies, by what it reports."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.mission.fleet.member import Member
from aos_gcs.ports import FlightMode, LandedState, Takeoff, VehicleState

ON_GROUND = LandedState.ON_GROUND
STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("armed", "landed", "height_m", "mode", "velocity_enu_mps", "flies"),
    [
        (False, ON_GROUND, 0.0, FlightMode.GUIDED, STILL, False),
        (False, LandedState.IN_AIR, 30.0, FlightMode.GUIDED, STILL, True),
        (True, LandedState.UNKNOWN, 0.0, FlightMode.GUIDED, STILL, True),
        (True, ON_GROUND, 0.0, FlightMode.GUIDED, STILL, False),
        (True, ON_GROUND, None, FlightMode.GUIDED, None, False),
        # It says that it is on the ground, and hovers or flies.
        (True, ON_GROUND, 30.0, FlightMode.GUIDED, STILL, True),
        (True, ON_GROUND, 3.0, FlightMode.GUIDED, (0.0, 4.0, 0.0), True),
        (True, ON_GROUND, 30.0, FlightMode.LAND, (0.0, 0.0, -1.5), True),
        # It has landed on a hill, and its motors run on for a while.
        (True, ON_GROUND, 30.0, FlightMode.LAND, STILL, False),
    ],
)
def test_who_moves_or_is_high_flies_whatever_it_says(
    *,
    armed: bool,
    landed: LandedState,
    height_m: float | None,
    mode: FlightMode,
    velocity_enu_mps: tuple[float, float, float] | None,
    flies: bool,
) -> None:
    state = VehicleState(
        vehicle_id=1,
        armed=armed,
        landed=landed,
        height_above_home_m=None if height_m is None else AboveHomeM(height_m),
        mode=mode,
        velocity_enu_mps=velocity_enu_mps,
    )
    member = Member(1, SimpleNamespace(state=state))  # type: ignore[arg-type]
    assert member.airborne is flies
    member.last_command = Takeoff(AboveHomeM(20.0))
    assert member.airborne is (flies or armed)
