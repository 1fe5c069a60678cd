"""Monitors the measured distances in the air: an alarm where two vehicles come close, a hold where too close.

Waypoints are vetted before they are sent; this is for what happens all the same: wind, wrong positions, pilots and
failsafes. Positions are carried forward by their age, so that a late one does not hide an approach, and two vehicles
count as close when they may be, by the accuracies of their positions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import EXACT, Accuracy, joint_errors_m
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.separation import minimum_separation
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, Hold, Severity

_REPEAT_S = 1.0
"""Time between two holds of a vehicle that moves on nevertheless."""
_HOVER_MPS = 0.3
"""Speed below which a vehicle hovers: gusts and noise stay below."""


@dataclass(frozen=True, slots=True, eq=False)
class _Located:
    member: Member
    position_enu_m: NDArray[np.float64]
    """Position now, extrapolated; shape (3,)."""
    accuracy: Accuracy


class ProximityWatch:
    """Remembers which pairs were reported, and which vehicles held, already."""

    def __init__(
        self, roster: Roster, clock: Clock, journal: Journal, accuracy_of: Callable[[Member], Accuracy]
    ) -> None:
        """``accuracy_of`` returns the accuracy of a vehicle's position; it is asked once there are limits."""
        self._roster = roster
        self._accuracy_of = accuracy_of
        self._clock = clock
        self._journal = journal
        self._close: set[tuple[int, int]] = set()
        self._violating: set[tuple[int, int]] = set()
        self._unlocated: set[int] = set()
        self._hold_again_at_s: dict[int, float] = {}
        self.min_separation_m: float | None = None
        """The smallest 3-D distance so far."""

    def look(self, limits: SafetyLimits | None) -> list[Member]:
        """Measure all distances in the air, raise alarms, and return the vehicles that have to hold now."""
        located = self._locate(limits)
        if len(located) < 2:
            self._close.clear()
            self._violating.clear()
            return []
        smallest_m, _ = minimum_separation(np.array([each.position_enu_m for each in located]))
        self.min_separation_m = min(smallest_m, self.min_separation_m or smallest_m)
        if limits is None:
            return []
        if smallest_m >= _farthest_of_note_m(located, limits.separation_m):
            self._close.clear()
            self._violating.clear()
            return []
        return self._judge(located, limits)

    def _locate(self, limits: SafetyLimits | None) -> list[_Located]:
        """Return the positions of airborne vehicles; report those whose last position is too old."""
        located, unlocated = [], set()
        for member in self._roster.airborne():
            position_enu_m, age_s = self._roster.position_enu_m(member), self._roster.position_age_s(member)
            if position_enu_m is None or age_s is None or (limits is not None and age_s > limits.max_position_age_s):
                unlocated.add(member.vehicle_id)
                continue
            velocity_enu_mps = np.array(member.state.velocity_enu_mps or (0.0, 0.0, 0.0))
            accuracy = EXACT if limits is None else self._accuracy_of(member)
            located.append(_Located(member, position_enu_m + age_s * velocity_enu_mps, accuracy))
        for vehicle_id in unlocated - self._unlocated:
            text = "airborne, but its position is unknown or old: its distance to others is not monitored. Return it"
            self._journal.notice(Severity.WARNING, text, vehicle_id)
        self._unlocated = unlocated
        return located

    def _judge(self, located: list[_Located], limits: SafetyLimits) -> list[Member]:
        close, violating, to_hold = set(), set(), []
        for one, other in combinations(located, 2):
            offset_m = other.position_enu_m - one.position_enu_m
            distance_m = float(np.linalg.norm(offset_m))
            joint_beside_m, joint_above_m = joint_errors_m(one.accuracy, other.accuracy)
            if not _may_be_close(offset_m, limits.separation_m, joint_beside_m, joint_above_m):
                continue
            pair = one.member.vehicle_id, other.member.vehicle_id
            close.add(pair)
            if pair not in self._close:
                allowed = f"the {limits.separation_m:.1f} m allowed"
                text = f"only {distance_m:.1f} m from vehicle {pair[1]}, less than {allowed}"
                if distance_m >= limits.separation_m:
                    text = (
                        f"{distance_m:.1f} m from vehicle {pair[1]}, ± {joint_beside_m:.1f} m beside and "
                        f"± {joint_above_m:.1f} m above or below: that may be less than {allowed}"
                    )
                self._journal.notice(Severity.CRITICAL, text, pair[0])
            beside_m, above_m = float(np.hypot(*offset_m[:2])), abs(float(offset_m[2]))
            is_beside = beside_m >= limits.hold_horizontal_m + joint_beside_m
            if is_beside or above_m >= limits.hold_vertical_m + joint_above_m:
                continue
            violating.add(pair)
            mover = _later_mover(one.member, other.member)
            if pair not in self._violating:
                text = f"{beside_m:.1f} m beside and {above_m:.1f} m above or below vehicle {pair[1]}: " + (
                    f"vehicle {mover.vehicle_id} is held" if mover is not None else "neither can be held"
                )
                self._journal.notice(Severity.CRITICAL, text, pair[0])
            if mover is not None and self._is_due(mover):
                to_hold.append(mover)
        self._close, self._violating = close, violating
        return to_hold

    def _is_due(self, member: Member) -> bool:
        now_s = self._clock.now_s()
        if now_s < self._hold_again_at_s.get(member.vehicle_id, now_s):
            return False
        self._hold_again_at_s[member.vehicle_id] = now_s + _REPEAT_S
        return True


def _farthest_of_note_m(located: list[_Located], separation_m: float) -> float:
    """Return the distance from which no pair may be close, by the worst accuracies of all."""
    worst = Accuracy(
        max(each.accuracy.horizontal_m for each in located), max(each.accuracy.vertical_m for each in located)
    )
    return separation_m + math.hypot(*joint_errors_m(worst, worst))


def _may_be_close(
    offset_m: NDArray[np.float64], separation_m: float, joint_beside_m: float, joint_above_m: float
) -> bool:
    """Return whether the true distance of a pair may be below the separation, by the errors of their positions."""
    beside_m = max(0.0, float(np.hypot(*offset_m[:2])) - joint_beside_m)
    above_m = max(0.0, abs(float(offset_m[2])) - joint_above_m)
    return bool(np.hypot(beside_m, above_m) < separation_m)


def _later_mover(one: Member, other: Member) -> Member | None:
    """Return the vehicle of a pair that was sent last and can be stopped; None if neither can.

    Neither a pilot nor a failsafe is overruled; a vehicle that hovers or holds already is not the one to stop.
    """
    return max((m for m in (one, other) if _can_be_stopped(m)), key=lambda member: member.sent_at_s, default=None)


def _can_be_stopped(member: Member) -> bool:
    velocity_enu_mps, command = member.state.velocity_enu_mps, member.last_command
    moves = velocity_enu_mps is None or float(np.linalg.norm(velocity_enu_mps)) > _HOVER_MPS
    is_left_alone = member.has_pilot or bool(member.state.failsafe)
    return moves and not is_left_alone and not isinstance(command, Hold)
