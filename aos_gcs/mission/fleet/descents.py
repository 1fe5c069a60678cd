"""Ways down: what is below a vehicle that is to land, also below the way on which it still comes to a stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.spacing import spread_apart
from aos_gcs.airspace.stopping import REACTION_S
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.motion import is_told_to_land, speed_mps
from aos_gcs.mission.fleet.obstacles import stop_enu_m
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold

FloatArray = NDArray[np.float64]

_COLUMN_SPACING_M: Final = 0.25
"""Distance of the columns that are looked at below the way to a stop."""
_MOST_COLUMNS: Final = 400
_HOLD_S: Final = 3.0
"""Time in which vehicles confirm that they stop before they land; a silent one delays the others by no more."""
_REST_S: Final = 8.0
"""Time after which vehicles that were told to stop are not waited for: one stops from 20 m/s in that."""


def moves(context: FlightContext, member: Member) -> bool:
    """Return whether a vehicle moves, so that it lands elsewhere than it is now."""
    return speed_mps(member) > context.settings.flight.arrival_speed_mps


def way_to_rest(context: FlightContext, member: Member) -> FloatArray | None:
    """Return the places where a vehicle may be until it has come to a stop, shape (n, 3), the last one there.

    From where it is now, by its last report, to where it stops when it brakes a second later than told. None while its
    position is not known.
    """
    position_enu_m = context.roster.position_enu_m(member)
    if position_enu_m is None:
        return None
    stop = stop_enu_m(member, position_enu_m, context.roster, context.settings.flight)
    if stop is None:
        return position_enu_m[None]
    stop = stop + REACTION_S * np.array(member.state.velocity_enu_mps)
    gaps = math.ceil(float(np.linalg.norm(stop - position_enu_m)) / _COLUMN_SPACING_M)
    return np.linspace(position_enu_m, stop, min(gaps, _MOST_COLUMNS) + 1)


def blocks_descent(context: FlightContext, member: Member, ignored: frozenset[int] = frozenset()) -> int | None:
    """Return the id of a vehicle in flight that is, or may come, below another that is to land; None if there is none.

    A vehicle that moves sinks while it brakes: nobody may be below any part of the way to its stop.

    Args:
        context: context of the flight.
        member: vehicle that is to descend.
        ignored: ids of vehicles that do not count.
    """
    tops_enu_m = way_to_rest(context, member)
    if tops_enu_m is None:
        return None
    bottoms_enu_m = tops_enu_m.copy()
    bottoms_enu_m[:, 2] = np.minimum(context.flight.bottom_m, tops_enu_m[:, 2])
    return context.flight.blocks_path(member, tops_enu_m, bottoms_enu_m, ignored)


async def come_to_rest(context: FlightContext, members: Sequence[Member]) -> None:
    """Stop vehicles that are to land and still move, and wait until they hover: then it is known what is below them."""
    moving = [member for member in members if moves(context, member)]
    if not moving:
        return
    for member in moving:
        context.roster.assign(member, Task.LANDING)
        member.safety_hold = Hold()
    context.journal.set_message("Landing: stopping first.")
    await context.flight.command_each(moving, lambda one: one.safety_hold or Hold(), _HOLD_S)
    await context.flight.wait_until(lambda: moving, lambda one: not moves(context, one), _REST_S)


async def clear_columns(context: FlightContext, members: Sequence[Member]) -> None:
    """Have vehicles that are to land hover, and move those that hover above one another apart, in their layers."""
    await come_to_rest(context, members)
    located = [
        (member, way[-1])
        for member in members
        if member.airborne and member.follows_us and (way := way_to_rest(context, member)) is not None
    ]
    if context.flight.limits is None or len(located) < 2:
        return
    places_enu_m = np.array([place_enu_m for _, place_enu_m in located])
    clearance_m = context.flight.clearance_m(members)
    if np.array_equal(spread_apart(places_enu_m, clearance_m), places_enu_m):
        return
    # Each may hover as far from its place as counts as arrived, and descends from there.
    apart_enu_m = spread_apart(places_enu_m, clearance_m + 2.0 * context.settings.flight.arrival_radius_m)
    context.journal.set_message("Landing: moving apart first.")
    for member, _ in located:
        context.roster.assign(member, Task.LANDING)
    requests = {
        member.vehicle_id: context.roster.layers.moved(place_enu_m, target_enu_m[:2])
        for (member, place_enu_m), target_enu_m in zip(located, apart_enu_m, strict=True)
    }
    await context.flight.transfer(requests, frozenset({Task.LANDING}), returning=True)


def to_clear(context: FlightContext) -> list[Member]:
    """Return the vehicles whose columns have to be clear before all land; one that is told to land does already."""
    flying = [member for member in context.roster.airborne() if member.follows_us and member.takes_part]
    return [member for member in flying if not is_told_to_land(member)]
