"""Reports at the end of a flight: who has landed, and where."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Severity

_ELSEWHERE_M = 10.0
"""Distance from its launch point beyond which a landed vehicle has to be looked for; far more than landings err."""


def report_pilots(context: FlightContext, flying: Iterable[Member]) -> None:
    """Report the vehicles that their pilots have to land."""
    for member in flying:
        if member.has_pilot and member.airborne:
            mode = member.state.mode_name or member.state.mode
            context.journal.notice(
                Severity.WARNING,
                f"flown by its pilot (mode {mode}): the pilot has to land it",
                member.vehicle_id,
            )


def report_landings(context: FlightContext, not_landed: Iterable[Member]) -> None:
    """Report how many vehicles have landed, and each that somebody has to look for."""
    for member in not_landed:
        text = "has not reported that it landed: check it on site"
        context.journal.notice(Severity.CRITICAL, text, member.vehicle_id)
    lost = context.roster.members(Task.LOST)
    for member in lost:
        text = "link lost: its own failsafe lands it. Check it on site"
        context.journal.notice(Severity.CRITICAL, text, member.vehicle_id)
    landed = context.roster.members(Task.LANDED)
    flown = sum(member.takes_part for member in context.roster.members())
    text = f"Mission over: {len(landed)} of {flown} vehicles landed{_report_elsewhere(context, landed)}."
    context.journal.set_message(text)


def _report_elsewhere(context: FlightContext, landed: Sequence[Member]) -> str:
    """Report vehicles that somebody has to fetch; return them in words to go on a sentence, empty for none."""
    away_m = {}
    for member in landed:
        position_enu_m = context.roster.position_enu_m(member)
        if position_enu_m is None or member.home_enu_m is None:
            continue
        distance_m = math.dist(position_enu_m[:2], member.home_enu_m[:2])
        if distance_m > _ELSEWHERE_M:
            away_m[member.vehicle_id] = distance_m
            text = f"landed {distance_m:.0f} m from its launch point"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
    if not away_m:
        return ""
    if len(away_m) > 1:
        return f", {len(away_m)} of them away from their launch points: {', '.join(map(str, sorted(away_m)))}"
    ((vehicle_id, distance_m),) = away_m.items()
    return f", vehicle {vehicle_id} {distance_m:.0f} m from its launch point"
