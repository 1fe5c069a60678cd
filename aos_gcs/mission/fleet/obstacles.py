"""Airborne vehicles as others have to keep clear of them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import Accuracy
from aos_gcs.airspace.stopping import DECELERATION_MPS2
from aos_gcs.airspace.traffic import Obstacle
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.motion import destination_enu_m, speed_mps
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import FlightMode, Land, ReturnToLaunch, Takeoff

FloatArray = NDArray[np.float64]

DRIFT_M: Final = 1.0
"""Distance by which a vehicle with a pilot may leave its place before others are vetted again: one that still braked
moved by 0.13 m."""

MOTION_LASTS_S: Final = 10.0
"""Age of a position up to which its vehicle may have moved on as reported then; failsafes act from 5 to 10 s on."""


def obstacle_of(
    member: Member,
    position_enu_m: FloatArray,
    roster: Roster,
    settings: FlightSettings,
    *,
    accuracy: Accuracy,
    bottom_m: float,
) -> Obstacle:
    """Return where an airborne vehicle may be: where it hovers, or the column in which it may be descending.

    For a vehicle sent somewhere that is the path there, too; for one that returns by its autopilot, or is lost and
    probably does, also the path to its launch point. A lost one turns for home when its failsafe acts; by then
    it may have reached the place that it was sent to.

    Args:
        member: the vehicle.
        position_enu_m: its position, shape (3,).
        roster: roster that it belongs to.
        settings: arrival radius and speed.
        accuracy: accuracy of its position.
        bottom_m: height above the origin down to which vehicles may descend.
    """
    layers, is_lost, command = roster.layers, member.task is Task.LOST, member.last_command
    goes_home = is_lost or member.state.mode is FlightMode.RETURN or isinstance(command, ReturnToLaunch)
    climbs = isinstance(command, Takeoff) and not roster.is_in_layer(member)
    top_enu_m = layers.at(member, position_enu_m) if climbs else None
    climbs_to_return = goes_home and layers.follow_ground
    return Obstacle(
        member.vehicle_id,
        position_enu_m,
        waypoint_enu_m=destination_enu_m(member, settings),
        stop_enu_m=stop_enu_m(member, position_enu_m, roster, settings),
        column=goes_home or climbs or not member.follows_us or isinstance(command, Land),
        top_m=None if top_enu_m is None else float(top_enu_m[2]),
        bottom_m=bottom_m,
        home_enu_m=member.home_enu_m if goes_home else None,
        turn_enu_m=destination_enu_m(member, settings) if is_lost else None,
        return_up_m=layers.return_up_m(member) if climbs_to_return else None,
        accuracy=accuracy,
        lands=isinstance(command, Land),
        drift_m=DRIFT_M if member.has_pilot else 0.0,
        left_alone=_why_left_alone(member, settings),
    )


def _why_left_alone(member: Member, settings: FlightSettings) -> str:
    """Return what keeps a vehicle from being asked to make way; empty where it can be asked, or is on its way."""
    if member.has_pilot:
        return "which has a pilot"
    if member.task is Task.LOST:
        return "which is not heard"
    hovers = speed_mps(member) <= settings.arrival_speed_mps
    return "which hovers in its failsafe" if member.state.failsafe and hovers else ""


def stop_enu_m(
    member: Member, position_enu_m: FloatArray, roster: Roster, settings: FlightSettings
) -> FloatArray | None:
    """Return where a vehicle would come to a stop, shape (3,), with its motion since its last position; or None.

    None, too, for one that has not been heard for so long that its last motion tells nothing: what it was ordered, and
    its failsafe, have decided since where it is.
    """
    present_mps, age_s = speed_mps(member), roster.position_age_s(member) or 0.0
    if present_mps <= settings.arrival_speed_mps or age_s > MOTION_LASTS_S:
        return None
    braking_s = age_s + present_mps / (2.0 * DECELERATION_MPS2)
    return position_enu_m + braking_s * np.array(member.state.velocity_enu_mps)
