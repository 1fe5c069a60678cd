"""Monitors jumps of reported positions, which no velocity explains: no aircraft jumps from one place to another.

A reset of an estimator, a jammed receiver or a damaged report shows as a jump. Which side of it is the true one, nobody
on the ground can tell. A path that was vetted from a wrong place is another one in the air, so the vehicle is not sent
on, and others keep clear of both places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from aos_gcs.airspace.accuracy import CONFIDENCE
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, Severity

_LEAST_M: Final = 3.0
"""Horizontal distance beyond the accuracy from which a jump puts the position in doubt."""
DOUBT_LASTS_S: Final = 10.0
"""Time of steady reports after which the place behind a jump counts as the vehicle's own."""


@dataclass(slots=True)
class _Track:
    """What the reports of one vehicle have jumped by."""

    accepted_m: tuple[float, float]
    """Sum of the jumps, east and north, behind which the place counts as the vehicle's own."""
    total_m: tuple[float, float]
    changed_at_s: float


class JumpWatch:
    """Puts positions that have jumped in doubt; reports each jump once, and when it is over."""

    def __init__(self, clock: Clock, journal: Journal) -> None:
        self._clock = clock
        self._journal = journal
        self._tracks: dict[int, _Track] = {}

    def look(self, member: Member) -> bool:
        """Take in what a vehicle reports; return whether it has to stop now, because its position has jumped."""
        total_m, now_s = member.state.position_jumps_m, self._clock.now_s()
        track = self._tracks.get(member.vehicle_id)
        if track is None or not member.airborne:
            self._tracks[member.vehicle_id] = _Track(total_m, total_m, now_s)
            member.position_doubt_m = 0.0
            return False
        if total_m != track.total_m:
            track.total_m, track.changed_at_s = total_m, now_s
        return self._judge(member, track, is_steady=now_s - track.changed_at_s >= DOUBT_LASTS_S)

    def _judge(self, member: Member, track: _Track, *, is_steady: bool) -> bool:
        """Put a vehicle's position in doubt, or take that back; return whether it has come into doubt now."""
        was_in_doubt = member.position_doubt_m > 0.0
        doubt_m = math.dist(track.total_m, track.accepted_m)
        limit_m = _LEAST_M + CONFIDENCE * accuracy_of(member.state).horizontal_m
        if is_steady or doubt_m <= limit_m:
            if is_steady:
                track.accepted_m = track.total_m
            member.position_doubt_m = 0.0
            if was_in_doubt:
                self._journal.notice(Severity.INFO, "position consistent with velocity again", member.vehicle_id)
            return False
        member.position_doubt_m = doubt_m
        if not was_in_doubt:
            jump = f"its position jumped by {doubt_m:.0f} m"
            text = f"{jump}. It is held, and others keep clear: check it, then resume it"
            self._journal.notice(Severity.CRITICAL, text, member.vehicle_id)
        return not was_in_doubt
