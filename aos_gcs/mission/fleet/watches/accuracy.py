"""Monitors how accurate the vehicles' altitudes are in flight: preflight has found them good enough for the layers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from aos_gcs.airspace.accuracy import CONFIDENCE, greatest_accuracy_m
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.datum import RTK_FIXED, RTK_FLOAT, stands
from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.condition import HEARD_AGO_S, has_position
from aos_gcs.mission.fleet.watches.debounce import Debounce
from aos_gcs.mission.journal import Journal
from aos_gcs.planning.checks.advice import MIN_LAYERS_WITHOUT_RTK_M
from aos_gcs.ports import Clock, Severity

_LASTING_S: Final = 5.0
"""Time for which an altitude is less accurate than the layers bear before it counts: spikes are shorter."""
_REJECTED_RATIO: Final = 1.0
"""Test ratio of the altitude from which estimators of both autopilots ignore what they measure."""
_WORSE: Final = 1.5
"""Factor by which an accuracy that was accepted on the ground may get worse."""


@dataclass(frozen=True, slots=True)
class _Accepted:
    """Accuracy with which a vehicle was launched: preflight has passed, or an operator has overridden it."""

    vertical_m: float
    has_rtk: bool


_UNKNOWN: Final = _Accepted(0.0, has_rtk=True)
"""Limits for a vehicle that was found in the air: the layers alone decide."""


class AccuracyWatch:
    """Finds vehicles whose altitude has become less accurate than their layers bear, and reports them once."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._accepted: dict[int, _Accepted] = {}
        self._inaccurate = Debounce(_LASTING_S)
        self._reasons: dict[int, str] = {}

    def look(self, separation_m: float, layer_spacing_m: float) -> dict[int, str]:
        """Take in what is reported now; return the reason to leave by vehicle, for those that are inaccurate."""
        for member in self._roster.members():
            if stands(member.state, member.last_command):
                self._accept(member)
            elif self._is_judged(member):
                self._judge(member, separation_m, layer_spacing_m)
            else:
                self._inaccurate.pause(member.vehicle_id)
        return self._reasons

    def _accept(self, member: Member) -> None:
        state = member.state
        self._accepted[member.vehicle_id] = _Accepted(accuracy_of(state).vertical_m, state.gps_fix == RTK_FIXED)
        self._reasons.pop(member.vehicle_id, None)
        self._inaccurate.forget(member.vehicle_id)
        member.is_inaccurate = False

    def _is_judged(self, member: Member) -> bool:
        """Return whether a vehicle flies, is heard and has a position: without one it is held for that."""
        link_age_s = self._roster.link_age_s(member)
        is_heard = link_age_s is not None and link_age_s <= HEARD_AGO_S
        return is_heard and member.airborne and member.task in FLYING and has_position(member.state)

    def _judge(self, member: Member, separation_m: float, layer_spacing_m: float) -> None:
        vehicle_id = member.vehicle_id
        problem = self._problem(member, separation_m, layer_spacing_m)
        if problem and self._inaccurate.counts(vehicle_id):
            self._reasons[vehicle_id] = problem
        if not self._inaccurate.has_changed(vehicle_id, bool(problem), self._clock.now_s()):
            return
        member.is_inaccurate = bool(problem)
        if problem:
            self._reasons[vehicle_id] = problem
            text = f"{problem}. Others keep clear of it, and it leaves the swarm. Check its reception and corrections"
            self._journal.notice(Severity.CRITICAL, text, vehicle_id)
        else:
            del self._reasons[vehicle_id]
            self._journal.notice(Severity.INFO, "its altitude is accurate enough again", vehicle_id)

    def _problem(self, member: Member, separation_m: float, layer_spacing_m: float) -> str:
        """Return what is wrong with a vehicle's accuracy, as a clause; empty if nothing."""
        accepted = self._accepted.get(member.vehicle_id, _UNKNOWN)
        borne_m = max(0.0, greatest_accuracy_m(separation_m, layer_spacing_m))
        state = member.state
        vertical_m, fix = accuracy_of(state).vertical_m, state.gps_fix
        if vertical_m > max(borne_m, _WORSE * accepted.vertical_m):
            layers = f"layers of {layer_spacing_m:g} m allow ± {CONFIDENCE * borne_m:.1f} m"
            return f"its altitude is accurate to ± {CONFIDENCE * vertical_m:.1f} m only (95 %), {layers}"
        if layer_spacing_m < MIN_LAYERS_WITHOUT_RTK_M and accepted.has_rtk and fix is not None and fix < RTK_FLOAT:
            return f"it has lost its RTK fix, which layers of {layer_spacing_m:g} m need"
        ratio = state.altitude_test_ratio
        if ratio is not None and ratio >= _REJECTED_RATIO:
            return f"its estimator rejects the heights that it measures ({ratio:.0%} of what it accepts)"
        return ""
