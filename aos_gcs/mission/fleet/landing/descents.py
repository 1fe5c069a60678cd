"""Ways down: what is below a vehicle that is to land, also below the way on which it still comes to a stop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import joint_errors_m
from aos_gcs.airspace.spacing import nearest_free, spread_apart
from aos_gcs.airspace.stopping import REACTION_S
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.motion import is_told_to_land, speed_mps
from aos_gcs.mission.fleet.obstacles import stop_enu_m
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold

FloatArray = NDArray[np.float64]

_COLUMN_SPACING_M: Final = 0.25
"""Distance of the columns that are looked at below the way to a stop."""
_MOST_COLUMNS: Final = 400
LANDING_ERROR_M: Final = 1.0
"""Distance by which a landing may err beside what positions err by: gusts, and drift on the last metres."""
_OWN_M: Final = 1.0
"""Distance from its own landing place within which a vehicle lands there."""
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
    bottoms_enu_m[:, 2] = np.minimum(context.bounds.bottom_m, tops_enu_m[:, 2])
    return context.flight.blocks_path(member, tops_enu_m, bottoms_enu_m, ignored)


async def come_to_rest(context: FlightContext, members: Sequence[Member]) -> None:
    """Stop vehicles that are to land and still move, and wait until they hover: then it is known what is below them."""
    moving = [member for member in members if moves(context, member)]
    if not moving:
        return
    for member in moving:
        context.roster.assign(member, Task.LANDING)
        member.hold_for_safety()
    context.journal.set_message("Landing: stopping first.")
    await context.flight.command_each(moving, lambda one: one.safety_hold or Hold(), _HOLD_S)
    await context.flight.wait_until(lambda: moving, lambda one: not moves(context, one), _REST_S)


async def clear_columns(context: FlightContext, members: Sequence[Member]) -> None:
    """Have vehicles that are to land hover, and move those apart, in their layers, that hover above others.

    Others are each other, vehicles in flight that are not moved, and those that stand on the ground.
    """
    await come_to_rest(context, members)
    located = {
        member.vehicle_id: (member, way[-1])
        for member in members
        if member.airborne and member.follows_us and (way := way_to_rest(context, member)) is not None
    }
    if context.bounds.limits is None or not located:
        return
    targets_m = _clear_places(context, [member for member, _ in located.values()], [p for _, p in located.values()])
    if all(np.array_equal(targets_m[vehicle_id], place[:2]) for vehicle_id, (_, place) in located.items()):
        return
    context.journal.set_message("Landing: moving apart first.")
    for member, _ in located.values():
        context.roster.assign(member, Task.LANDING)
    requests = {
        vehicle_id: context.roster.layers.moved(place_enu_m, targets_m[vehicle_id])
        for vehicle_id, (_, place_enu_m) in located.items()
    }
    await context.flight.transfer(requests, frozenset({Task.LANDING}), returning=True)


def _clear_places(
    context: FlightContext, members: Sequence[Member], places_enu_m: Sequence[FloatArray]
) -> dict[int, FloatArray]:
    """Return where vehicles may land, shape (2,) each: where they hover, or near that."""
    flight, roster = context.flight, context.roster
    clearance_m = flight.clearance_m(members)
    # Each may hover as far from its place as counts as arrived, and descends from there.
    apart_m = clearance_m + 2.0 * context.settings.flight.arrival_radius_m
    targets_m = np.array(places_enu_m)
    if not np.array_equal(spread_apart(targets_m, clearance_m), targets_m):
        targets_m = spread_apart(targets_m, apart_m)
    targets_m = targets_m[:, :2]
    flying = [
        position_enu_m[:2]
        for other in roster.members()
        if other.airborne and other not in members and (position_enu_m := roster.position_enu_m(other)) is not None
    ]
    for row, member in enumerate(members):
        is_below_others = any(math.dist(targets_m[row], other_m) < clearance_m for other_m in flying)
        if not is_below_others and stands_near(context, member, targets_m[row]) is None:
            continue
        others_m = [*np.delete(targets_m, row, axis=0), *flying]
        standing = _standing(context, member)
        free_m = nearest_free(
            targets_m[row],
            np.array([*others_m, *(place_m for place_m, _ in standing.values())]),
            np.array([apart_m] * len(others_m) + [wide_m + LANDING_ERROR_M for _, wide_m in standing.values()]),
            lambda candidates_m: is_within(context, candidates_m),
        )
        if free_m is not None:
            targets_m[row] = free_m
    return {member.vehicle_id: target_m for member, target_m in zip(members, targets_m, strict=True)}


def is_within(context: FlightContext, places_m: FloatArray) -> NDArray[np.bool_]:
    """Return which places, shape (n, 2), keep the margins of the geofence and of all no-go zones."""
    limits = context.bounds.limits
    is_inside = np.ones(len(places_m), dtype=bool)
    for boundary in () if limits is None else limits.boundaries():
        is_inside &= boundary.depths_m(places_m) >= boundary.margin_m
    return is_inside


def stands_below(context: FlightContext, member: Member) -> int | None:
    """Return the id of a vehicle that stands on the ground where another would land now; None if there is none."""
    way_enu_m = way_to_rest(context, member)
    if way_enu_m is None:
        return None
    # It touches down near the end of its way: the wind, and how hard it brakes, are not known.
    return _first_standing(near_standing(context, member, way_enu_m[len(way_enu_m) // 2 :, :2]))


def refuse_landing(context: FlightContext, member: Member) -> Refusal | None:
    """Return why a vehicle must not land where it is, and what to do instead; None if it may."""
    below = blocks_descent(context, member)
    if below is not None and moves(context, member):
        return Refusal(f"vehicle {below} is or may come below it before it stops: hold it, then land it")
    if below is not None:
        return Refusal(f"vehicle {below} is or may come below it: hold or return that one, or land all")
    if (standing := stands_below(context, member)) is not None:
        return Refusal(f"vehicle {standing} stands on the ground below it: return it")
    return None


def stands_near(context: FlightContext, member: Member, place_m: FloatArray) -> int | None:
    """Return the id of a vehicle on the ground that stands too near to a place, shape (2,), to land there, or None."""
    return _first_standing(near_standing(context, member, place_m[None]))


def near_standing(context: FlightContext, member: Member, places_m: FloatArray) -> dict[int, NDArray[np.bool_]]:
    """Return which places, shape (n, 2), are too near to each vehicle that stands on the ground, by its id.

    At its own landing place a vehicle lands beside those that stand as near as launch points are, and no nearer than
    the separation. Anywhere else, what landings err by is added.
    """
    limits, own_enu_m = context.bounds.limits, landing_place_enu_m(member)
    if limits is None:
        return {}
    is_own = np.zeros(len(places_m), dtype=bool)
    if own_enu_m is not None:
        is_own = np.hypot(*(places_m - own_enu_m[:2]).T) <= _OWN_M
    return {
        other_id: np.hypot(*(places_m - other_m).T) < np.where(is_own, limits.separation_m, wide_m)
        for other_id, (other_m, wide_m) in _standing(context, member).items()
    }


def _first_standing(is_near: Mapping[int, NDArray[np.bool_]]) -> int | None:
    return next((other_id for other_id, near in is_near.items() if near.any()), None)


def _standing(context: FlightContext, member: Member) -> dict[int, tuple[FloatArray, float]]:
    """Return where the other vehicles on the ground stand, shape (2,), and how far from each this one may land, by id.

    One that is not heard any more stands where it was heard last.
    """
    limits, roster, flight = context.bounds.limits, context.roster, context.flight
    if limits is None:
        return {}
    standing = {}
    for other in roster.members():
        position_enu_m = roster.position_enu_m(other)
        if other is not member and not other.airborne and position_enu_m is not None:
            errors_m, _ = joint_errors_m(flight.accuracy(member), flight.accuracy(other))
            standing[other.vehicle_id] = position_enu_m[:2], limits.separation_m + LANDING_ERROR_M + errors_m
    return standing


def landing_place_enu_m(member: Member) -> FloatArray | None:
    """Return where a vehicle lands when it returns, shape (3,), as far as that is decided.

    That is its launch point, or a place of its own near it or about the return point.
    """
    return member.home_enu_m if member.landing_enu_m is None else member.landing_enu_m


def to_clear(context: FlightContext) -> list[Member]:
    """Return the vehicles whose columns have to be clear before all land; one that is told to land does already."""
    flying = [member for member in context.roster.airborne() if member.follows_us and member.takes_part]
    return [member for member in flying if not is_told_to_land(member)]
