"""Withdraws ways that were granted before another vehicle needed more room.

A pilot has taken it over, it was found to be elsewhere than reported, or it flies home and comes down by its failsafe,
also while it is not heard.
"""

from __future__ import annotations

from typing import Final

from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, Goto, Land, Severity

_TOLERANCE_M: Final = 0.2
"""Distance by which vehicles may come too near before a way is withdrawn: they drift while they are on it."""
_REPEAT_S: Final = 1.0
"""Time between two holds of one vehicle."""


class WayWatch:
    """Watches the ways of vehicles that need more room than others, and those of the vehicles about them."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._again_at_s: dict[int, float] = {}

    def look(self, flight: FlightControl) -> list[Member]:
        """Return the vehicles that have to stop now, each of which is reported; what they may fly is vetted anew."""
        flying = [member for member in self._roster.members() if member.airborne]
        wide = [member for member in flying if _needs_room(member)]
        if not wide:
            return []
        under_way = [member for member in flying if _follows_a_goto(member) and not flight.has_arrived(member)]
        return [
            member for member in under_way if self._is_withdrawn(flight, member, flying if member in wide else wide)
        ]

    def _is_withdrawn(self, flight: FlightControl, member: Member, about: list[Member]) -> bool:
        now_s = self._clock.now_s()
        if now_s < self._again_at_s.get(member.vehicle_id, now_s):
            return False
        admission = flight.rest_of_way(member, [other for other in about if other is not member], _TOLERANCE_M)
        if admission.fraction >= 1.0:
            return False
        self._again_at_s[member.vehicle_id] = now_s + _REPEAT_S
        member.hold_for_safety()
        self._journal.notice(Severity.WARNING, f"stops on its way: {admission.reason}", member.vehicle_id)
        return True


def _needs_room(member: Member) -> bool:
    """Return whether others have to keep farther away from a vehicle than its layer and its accuracy ask for."""
    # Where it lands by our command, the ways of others have been looked at.
    flies_by_itself = not member.follows_us and not isinstance(member.last_command, Land)
    is_doubted = member.is_inaccurate or member.altitude_doubt_m or member.position_doubt_m
    return bool(member.has_pilot or member.task is Task.LOST or flies_by_itself or is_doubted)


def _follows_a_goto(member: Member) -> bool:
    return member.follows_us and member.task is not Task.LOST and isinstance(member.last_command, Goto)
