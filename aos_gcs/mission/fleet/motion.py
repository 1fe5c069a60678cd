"""Motion of a vehicle: how fast it flies, where to by its latest command, and whether it may be sent elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.vehicles import TASK_NAMES, Task
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Goto, Land

FloatArray = NDArray[np.float64]


def speed_mps(member: Member) -> float:
    """Return the speed that a vehicle reports; 0 where it reports none."""
    velocity_enu_mps = member.state.velocity_enu_mps
    return 0.0 if velocity_enu_mps is None else float(np.linalg.norm(velocity_enu_mps))


def destination_enu_m(member: Member, flight: FlightSettings) -> FloatArray | None:
    """Return where a vehicle flies to, shape (3,): by its latest command, or by one of a station before this one.

    None where that command does not name a place. The station before has left a place only to a vehicle that still
    flies by its commands.
    """
    if isinstance(member.last_command, Goto):
        return member.waypoint_enu_m
    is_sent_before = member.last_command is None and member.follows_us and speed_mps(member) > flight.arrival_speed_mps
    return member.waypoint_enu_m if is_sent_before else None


def hovers_at_waypoint(member: Member, position_enu_m: FloatArray | None, flight: FlightSettings) -> bool:
    """Return whether a vehicle is seen to hover at the place that it was last sent to."""
    if position_enu_m is None or member.waypoint_enu_m is None:
        return False
    distance_m = float(np.linalg.norm(position_enu_m - member.waypoint_enu_m))
    return distance_m <= flight.arrival_radius_m and speed_mps(member) <= flight.arrival_speed_mps


def must_stop(member: Member, position_enu_m: FloatArray | None, flight: FlightSettings) -> bool:
    """Return whether a vehicle that must not be sent on has to stop: it still flies to a waypoint of ours.

    One that was sent there for its present task, such as its way home, flies on: that path was vetted, is kept free,
    and leads where it has to go. What a vehicle of the swarm, or the swarm that it has left, was sent to may be far.
    """
    if destination_enu_m(member, flight) is None or hovers_at_waypoint(member, position_enu_m, flight):
        return False
    return member.task is Task.SWARM or member.waypoint_task is not member.task


def is_ours(member: Member, tasks: frozenset[Task]) -> bool:
    """Return whether a waypoint may be sent: a goto would end a pilot's flight, a hold, a return or a landing."""
    return member.task in tasks and member.follows_us


def why_left(member: Member) -> str:
    """Return why a vehicle is not sent to a waypoint that was planned for it."""
    mode = member.state.mode_name or member.state.mode
    return f"held: it left the swarm ({TASK_NAMES[member.task]}, mode {mode})"


def is_told_to_land(member: Member) -> bool:
    """Return whether a vehicle lands by its latest order, though its mode may not show that yet."""
    return member.task is Task.LANDING and isinstance(member.last_command, Land)
