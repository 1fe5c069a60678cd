"""Homes of vehicles on the ground: where they are reported, and where they will be once the motors run.

Autopilots set their home where they are switched on. ArduCopter keeps it until it is armed, PX4 moves it along on the
ground; both keep one that somebody has set, and return to it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.fleet.datum import is_grounded, same_place_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.ports import Clock, VehicleState

_REPORTED_S = 3.0
"""Time for which a vehicle is waited for to report the home that it was armed at."""
_POLL_S = 0.2


def home_away_m(state: VehicleState) -> float | None:
    """Return how far from a vehicle that stands on the ground its home is; None where it is there, or not known."""
    if state.home is None or state.position is None or not is_grounded(state):
        return None
    away_m = float(np.hypot(*LocalFrame(state.home).to_enu(state.position)[:2]))
    return away_m if away_m > same_place_m(state) else None


def next_home(state: VehicleState) -> GeodeticPosition | None:
    """Return where a vehicle's home will be once it is armed: where it stands, if its home is elsewhere before."""
    return state.home if state.armed or home_away_m(state) is None else state.position


def take_off_point_enu_m(roster: Roster, member: Member) -> NDArray[np.float64] | None:
    """Return the next home of a vehicle, shape (3,), on the surveyed ground; None while it is not known."""
    home = next_home(member.state)
    if roster.frame is None or home is None:
        return None
    if roster.ground is not None:
        home = replace(home, altitude_amsl_m=roster.ground.altitude_amsl_m(member.vehicle_id))
    return roster.frame.to_enu(home)


async def home_elsewhere(clock: Clock, member: Member) -> Refusal | None:
    """Return why a vehicle whose motors have just started must not take off: it would return elsewhere. None if not."""
    armed_at_s = clock.now_s()
    while (away_m := home_away_m(member.state)) is not None:
        if clock.now_s() - armed_at_s > _REPORTED_S:
            return Refusal(
                f"its autopilot has its home {away_m:.1f} m from where it stands, and would return there. Restart it "
                "where it stands"
            )
        await clock.sleep(_POLL_S)
    return None
