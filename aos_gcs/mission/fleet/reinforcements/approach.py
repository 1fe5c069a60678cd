"""Flight of one vehicle to others that fly on: it meets them on their way, in its own altitude layer."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.vehicles import Task

NEAR_M = 6.0
"""Horizontal distance at which a vehicle has met those that it flies to."""
_AIM_S = 1.0
"""Time after which it is aimed anew."""
_POLL_S = 0.2
_SHARE = 0.8
"""Share of the cruise speed that an approach counts with: accelerating and turning take their time."""

_JOINING = frozenset({Task.JOINING})


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """Vehicles that fly on together, horizontally."""

    place_m: NDArray[np.float64]
    """Middle of the vehicles, shape (2,)."""
    velocity_mps: NDArray[np.float64]
    """Shape (2,)."""
    end_m: NDArray[np.float64]
    """The middle of their waypoints, shape (2,)."""


class Approach:
    """Flies a vehicle that joins to a place in the line that may move.

    Args:
        context: context of the flight.
    """

    def __init__(self, context: FlightContext) -> None:
        self._context = context

    async def fly(self, member: Member, leaders: Callable[[], Sequence[Member]]) -> bool:
        """Fly to the middle of the leaders, and return whether the vehicle got there.

        It does not while it gets another task, is taken over, or has no leader left.

        Args:
            member: vehicle with an altitude layer, in the air.
            leaders: returns the vehicles that it flies to, as they are now.
        """
        context = self._context
        clock, roster, flight = context.clock, context.roster, context.flight
        until_s, aim_at_s = clock.now_s() + context.settings.deadlines.transfer_s, clock.now_s()
        while member.task is Task.JOINING and member.follows_us and clock.now_s() < until_s:
            here_enu_m, moving = roster.position_enu_m(member), self._middle(leaders())
            if here_enu_m is None or moving is None:
                return False
            if float(np.linalg.norm(moving.place_m - here_enu_m[:2])) <= NEAR_M and roster.is_in_layer(member):
                return True
            if clock.now_s() >= aim_at_s:
                aim_at_s = clock.now_s() + _AIM_S
                aim_m = meeting_place_m(here_enu_m[:2], moving, _SHARE * context.settings.flight.cruise_speed_mps)
                place_enu_m = roster.layers.at(member, np.array([*aim_m, here_enu_m[2]]))
                if place_enu_m is not None:
                    await flight.send(flight.vet({member.vehicle_id: place_enu_m}, _JOINING), tasks=_JOINING)
            await clock.sleep(_POLL_S)
        return False

    def _middle(self, leaders: Sequence[Member]) -> Moving | None:
        """Return how the leaders move; None where no position of theirs is known."""
        roster, rows = self._context.roster, []
        for leader in leaders:
            position_enu_m, velocity_enu_mps = roster.position_enu_m(leader), leader.state.velocity_enu_mps
            if position_enu_m is None:
                continue
            waypoint_enu_m = position_enu_m if leader.waypoint_enu_m is None else leader.waypoint_enu_m
            rows.append([position_enu_m[:2], (velocity_enu_mps or (0.0, 0.0))[:2], waypoint_enu_m[:2]])
        return Moving(*np.mean(np.array(rows), axis=0)) if rows else None


def meeting_place_m(here_m: NDArray[np.float64], moving: Moving, speed_mps: float) -> NDArray[np.float64]:
    """Return where a vehicle meets others that move on straight to their waypoints, shape (2,), never beyond these.

    Args:
        here_m: place of the vehicle, shape (2,).
        moving: the others.
        speed_mps: speed of the vehicle.
    """
    way_m, velocity_mps = moving.place_m - here_m, moving.velocity_mps
    # |way + t velocity| = t speed, for the smallest t above 0.
    a = speed_mps**2 - float(velocity_mps @ velocity_mps)
    b, c = float(way_m @ velocity_mps), float(way_m @ way_m)
    if a <= 0.0:
        return moving.end_m
    moved_m = (b + math.sqrt(b * b + a * c)) / a * velocity_mps
    is_beyond = float(np.linalg.norm(moved_m)) > float(np.linalg.norm(moving.end_m - moving.place_m))
    return moving.end_m if is_beyond else moving.place_m + moved_m
