"""Monitors whether a vehicle's positions follow from its velocity: no aircraft jumps from one place to another.

A reset of an estimator, a jammed receiver or a damaged report shows as a jump. Which side of it is the true one, nobody
on the ground can tell. A path that was vetted from a wrong place is another one in the air, so the vehicle is not sent
on, and others keep clear of both places.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import CONFIDENCE
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.roster import Member, Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, Severity

_JUMP_M: Final = 3.0
"""Horizontal distance beyond the accuracy, from which a difference counts: resets by less are everyday."""
_ACCELERATION_MPS2: Final = 5.0
"""Change of velocity between two reports that velocities at both ends do not show."""
_GAP_S: Final = 3.0
"""Time between two reports after which they are not compared: a vehicle may have been anywhere between them."""
DOUBT_LASTS_S: Final = 10.0
"""Time of steady reports after which the place behind a jump counts as the vehicle's own."""


@dataclass(slots=True)
class _Track:
    """Last report of one vehicle, and what its reports have jumped by."""

    at_s: float
    position_enu_m: NDArray[np.float64]
    velocity_enu_mps: NDArray[np.float64]
    jumped_m: NDArray[np.float64]
    """Sum of the jumps that have not been accepted, shape (2,); about 0 once the reports have jumped back."""
    jumped_at_s: float | None = None
    """Time of the last jump; None while none is in doubt."""


class JumpWatch:
    """Compares each position with the one before and the velocities; reports jumps once, and when they are over."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._tracks: dict[int, _Track] = {}

    def look(self, member: Member) -> bool:
        """Take in what a vehicle reports; return whether it has to stop now, because its position has jumped."""
        position_enu_m, velocity_enu_mps = self._roster.position_enu_m(member), member.state.velocity_enu_mps
        at_s = member.state.position_at_s
        if not member.airborne or position_enu_m is None or velocity_enu_mps is None or at_s is None:
            self._tracks.pop(member.vehicle_id, None)
            member.position_doubt_m = 0.0
            return False
        velocity_m = np.array(velocity_enu_mps)
        track = self._tracks.get(member.vehicle_id)
        if track is None:
            self._tracks[member.vehicle_id] = _Track(at_s, position_enu_m, velocity_m, np.zeros(2))
            return False
        has_jumped = False
        if at_s > track.at_s:
            elapsed_s = at_s - track.at_s
            expected_m = track.position_enu_m + elapsed_s * (track.velocity_enu_mps + velocity_m) / 2.0
            jump_m = (position_enu_m - expected_m)[:2]
            limit_m = self._limit_m(member) + _ACCELERATION_MPS2 * elapsed_s**2 / 2.0
            has_jumped = elapsed_s <= _GAP_S and float(np.hypot(*jump_m)) > limit_m
            if has_jumped:
                track.jumped_m, track.jumped_at_s = track.jumped_m + jump_m, self._clock.now_s()
            track.at_s, track.position_enu_m, track.velocity_enu_mps = at_s, position_enu_m, velocity_m
        return self._judge(member, track, has_jumped=has_jumped)

    def _judge(self, member: Member, track: _Track, *, has_jumped: bool) -> bool:
        """Put a vehicle's position in doubt, or take that back; return whether it has come into doubt now."""
        if track.jumped_at_s is None:
            return False
        was_in_doubt = member.position_doubt_m > 0.0
        doubt_m = float(np.hypot(*track.jumped_m))
        is_accepted = self._clock.now_s() - track.jumped_at_s >= DOUBT_LASTS_S
        if is_accepted or doubt_m <= self._limit_m(member):
            track.jumped_m, track.jumped_at_s, member.position_doubt_m = np.zeros(2), None, 0.0
            if was_in_doubt:
                self._journal.notice(Severity.INFO, "its positions follow from its velocity again", member.vehicle_id)
            return False
        member.position_doubt_m = doubt_m
        if has_jumped and not was_in_doubt:
            jump = f"its position jumped by {doubt_m:.0f} m"
            text = f"{jump}. It is held, and others keep clear: check it, then resume it"
            self._journal.notice(Severity.CRITICAL, text, member.vehicle_id)
        return has_jumped and not was_in_doubt

    @staticmethod
    def _limit_m(member: Member) -> float:
        return _JUMP_M + CONFIDENCE * accuracy_of(member.state).horizontal_m
