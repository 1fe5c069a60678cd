"""Vehicles that have not left the columns above their launch points: they land straight down, and climb no further."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.landing.descents import blocks_descent
from aos_gcs.mission.fleet.member import Member


def in_launch_columns(context: FlightContext) -> list[Member]:
    """Return the vehicles that follow us below their layers above their launch points, with nothing else below them.

    Launch points lie apart, so that descents there do not come nearer to one another. Before there are limits, no
    vehicle is in such a column.
    """
    roster, limits = context.roster, context.bounds.limits
    if limits is None:
        return []
    low = [member for member in roster.airborne() if _is_low_at_home(context, member, limits.separation_m)]
    return [member for member in low if _is_free(context, member, low)]


def _is_low_at_home(context: FlightContext, member: Member, reach_m: float) -> bool:
    roster, position_enu_m = context.roster, context.roster.position_enu_m(member)
    if not (member.takes_part and member.follows_us) or position_enu_m is None:
        return False
    column_enu_m = roster.own_column_enu_m(member)
    if member.home_enu_m is None or column_enu_m is None or roster.is_in_layer(member):
        return False
    beside_m = float(np.hypot(*(position_enu_m - member.home_enu_m)[:2]))
    return beside_m <= reach_m and float(position_enu_m[2]) < float(column_enu_m[2])


def _is_free(context: FlightContext, member: Member, low: Iterable[Member]) -> bool:
    ignored = frozenset(other.vehicle_id for other in low)
    return blocks_descent(context, member, ignored) is None
