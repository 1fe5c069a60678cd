"""Places where vehicles stand that are to take off in mid-mission: launch points anew, by where they stand now.

Autopilots move their home to where they are armed. A vehicle that has landed elsewhere still reports the home of its
former flight until then, so that neither place nor height of that says where it will climb.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.datum import home_altitude_m, same_place_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.actions import Refusal

_SAME_GROUND_M = 0.25
"""Largest error of the ground that a vehicle is assumed to stand on."""
_REPORTED_S = 3.0
"""Time for which a vehicle is waited for to report the home that it was armed at."""
_POLL_S = 0.2


def find_launch_place(context: FlightContext, member: Member) -> NDArray[np.float64] | Refusal:
    """Return the launch point of a vehicle by where it stands, shape (3,), or why it has none.

    The ground there, which the roster notes, has to be known as well as at the launch points: the vehicle stands where
    its autopilot has its home, or the ground was measured by RTK, or an elevation model says how much it rises.
    """
    roster, state = context.roster, member.state
    reported_enu_m, here_enu_m = roster.launch_point_enu_m(member), roster.position_enu_m(member)
    if reported_enu_m is None or state.home is None:
        return Refusal("its home position is not known yet")
    if here_enu_m is None or state.position is None:
        return Refusal("its position is not known yet")
    known_enu_m = reported_enu_m if member.home_enu_m is None else member.home_enu_m
    is_elsewhere = _beside_m(here_enu_m, known_enu_m) > same_place_m(state)
    if is_elsewhere and (refusal := _near_launch_point(context, member, here_enu_m)) is not None:
        return refusal
    altitude_amsl_m = state.home.altitude_amsl_m
    place = state.position if is_elsewhere else roster.local_frame().to_geodetic(known_enu_m)
    if roster.ground is not None:
        ground = roster.ground.with_vehicle(state)
        if ground is roster.ground and is_elsewhere:
            rise_m = _rise_m(context, known_enu_m, here_enu_m)
            away_m = _beside_m(here_enu_m, reported_enu_m)
            if rise_m is None and away_m > same_place_m(state):
                return Refusal(
                    f"stands {away_m:.0f} m from its launch point, and the height of the ground there is not known: "
                    "carry it back, or restart it on ground that is level with the launch points"
                )
            # Restarted elsewhere, it counts as any vehicle does that is placed on the launch site: that is level.
            relief_m = 0.0 if rise_m is None else ground.relief_m.get(member.vehicle_id, 0.0) + rise_m
            ground = ground.with_relief(member.vehicle_id, relief_m)
        roster.ground, altitude_amsl_m = ground, ground.altitude_amsl_m(member.vehicle_id)
    return roster.local_frame().to_enu(replace(place, altitude_amsl_m=altitude_amsl_m))


def _near_launch_point(context: FlightContext, member: Member, place_enu_m: NDArray[np.float64]) -> Refusal | None:
    """Return why a vehicle must not take off for the launch points of others, where they may land; None if it may."""
    limits = context.bounds.limits
    for other in context.roster.members():
        if limits is None or other is member or other.home_enu_m is None or not context.roster.may_fly(other):
            continue
        apart_m = _beside_m(place_enu_m, other.home_enu_m)
        if apart_m < limits.launch_distance_m:
            return Refusal(
                f"stands {apart_m:.1f} m from the launch point of vehicle {other.vehicle_id}, which may land there: "
                f"carry it {limits.launch_distance_m:.1f} m away"
            )
    return None


async def moved_home(context: FlightContext, member: Member, assumed_offset_m: float) -> Refusal | None:
    """Return how the home of a vehicle whose motors have just started differs from its launch point; None if not.

    Args:
        context: context of the flight.
        member: vehicle that still stands on the ground, armed.
        assumed_offset_m: error of its altitude that was assumed before it was armed.
    """
    clock, armed_at_s = context.clock, context.clock.now_s()
    while (difference := _difference(context, member, assumed_offset_m, armed_at_s)) is not None:
        if clock.now_s() - armed_at_s > _REPORTED_S:
            return difference
        await clock.sleep(_POLL_S)
    return None


def _difference(context: FlightContext, member: Member, assumed_offset_m: float, armed_at_s: float) -> Refusal | None:
    roster, state = context.roster, member.state
    reported_enu_m, altitude_m = roster.launch_point_enu_m(member), home_altitude_m(state)
    reported_at_s, ground = state.position_at_s, roster.ground
    if reported_enu_m is None or altitude_m is None or member.home_enu_m is None:
        return Refusal("its home position is not known")
    if reported_at_s is None or reported_at_s < armed_at_s:
        return Refusal("it has not reported its position since its motors started")
    beside_m = _beside_m(reported_enu_m, member.home_enu_m)
    if beside_m > same_place_m(state):
        return Refusal(f"its autopilot has its home {beside_m:.1f} m from where it stands. Join it again")
    error_m = 0.0 if ground is None else altitude_m - ground.altitude_amsl_m(member.vehicle_id) - assumed_offset_m
    if abs(error_m) > _SAME_GROUND_M:
        return Refusal(f"its autopilot has moved its home by {error_m:+.1f} m in height. Join it again")
    return None


def _rise_m(context: FlightContext, known_enu_m: NDArray[np.float64], here_enu_m: NDArray[np.float64]) -> float | None:
    """Return how much the ground rises from one place to another by the elevation model; None if it does not say."""
    model = context.bounds.ground
    if model is None:
        return None
    rise_m = model.model_height_m(here_enu_m[:2]) - model.model_height_m(known_enu_m[:2])
    return rise_m if math.isfinite(rise_m) else None


def _beside_m(one_enu_m: NDArray[np.float64], other_enu_m: NDArray[np.float64]) -> float:
    return float(np.hypot(*(one_enu_m - other_enu_m)[:2]))
