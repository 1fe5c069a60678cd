"""Vehicles that may still fly after the end of a mission."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Final

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.landing.launch_columns import in_launch_columns
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.links import LONGEST_DOUBT_S
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Land, ReturnToLaunch

LONGEST_FAILSAFE_S: Final = 60.0
"""Longest silence after which a vehicle's own failsafe acts; preflight refuses longer ones. Until then it hovers."""
_FAREWELL_S = 5.0
"""Time limit for sending vehicles home when a mission is torn down, real seconds."""


def is_any_heard_flying(roster: Roster, lost_s: float) -> bool:
    """Return whether a vehicle that is heard flies, or still runs its motors after a flight for the mission.

    Args:
        roster: the vehicles heard.
        lost_s: silence after which a vehicle is lost.
    """
    ages_s = [roster.link_age_s(member) for member in roster.members() if roster.may_fly(member)]
    return any(age_s is not None and age_s <= lost_s for age_s in ages_s)


def may_any_hover_unheard(roster: Roster) -> bool:
    """Return whether a vehicle that is lost may hover where it was, since its failsafe need not have acted yet."""
    ages_s = [roster.link_age_s(member) for member in roster.members(Task.LOST) if member.airborne]
    return any(age_s is not None and age_s <= LONGEST_FAILSAFE_S + LONGEST_DOUBT_S for age_s in ages_s)


async def send_all_home(context: FlightContext) -> None:
    """Send home the vehicles that fly under our command, as the last order of a station that leaves."""
    left = [member for member in context.roster.airborne() if member.follows_us]
    low = in_launch_columns(context)
    with suppress(TimeoutError):
        async with asyncio.timeout(_FAREWELL_S):
            # An autopilot's own return would climb first.
            await context.flight.command_each(left, lambda member: Land() if member in low else ReturnToLaunch())
