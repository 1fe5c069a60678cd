"""Watch over the sensors of vehicles in flight: position estimate, satellite fix, vibration, clock, battery."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.debounce import Debounce
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, Severity, VehicleState

MIN_GPS_FIX = 3
MAX_VIBRATION_MPS2 = 30.0
"""Level from which ArduPilot's documentation warns of wrong altitudes."""
MAX_VIBRATION_METRIC_MPS2 = 9.81
"""Level of PX4's own metric, of differences between samples, from which its flight reviews call vibration too high."""
MAX_CLOCK_DRIFT = 1e-3
MAX_BATTERY_AGE_S = 20.0
"""Time without a report of the battery, while the vehicle is heard, after which it has to return."""
HEARD_AGO_S = 2.0
"""Age up to which what a vehicle reports is judged."""
_POSITION, _FIX, _VIBRATION, _CLOCK = "position", "fix", "vibration", "clock"
_LASTING_S: Mapping[str, float] = MappingProxyType({_POSITION: 3.0, _FIX: 3.0, _VIBRATION: 3.0, _CLOCK: 20.0})
"""Time for which a problem lasts before it is reported, and for which it is gone before that is.

A clock's rate comes of answers over minutes: a busy computer shows one that is none for some seconds.
"""
_GOOD_AGAIN: Mapping[str, str] = MappingProxyType(
    {
        _POSITION: "its estimated position is good again",
        _FIX: "it has a 3D position fix again",
        _VIBRATION: "its vibration is normal again",
        _CLOCK: "its clock is steady again",
    }
)


class ConditionWatch:
    """Reports of each problem once, when it has lasted, and once when it is over."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._problems = {name: Debounce(lasting_s) for name, lasting_s in _LASTING_S.items()}
        """Problems by name, of all vehicles."""
        self._heard_since_s: dict[int, float] = {}
        """Time since which a vehicle has been heard without a gap."""

    def look(self, member: Member) -> bool:
        """Report what has changed; return whether the vehicle has to stop, because its position cannot be trusted."""
        now_s, link_age_s = self._clock.now_s(), self._roster.link_age_s(member)
        if link_age_s is None or link_age_s > HEARD_AGO_S or not member.airborne:
            self._heard_since_s[member.vehicle_id] = now_s
            return False
        self._heard_since_s.setdefault(member.vehicle_id, now_s)
        if member.task not in FLYING:
            return False
        found = problems(member.state)
        vehicle_id = member.vehicle_id
        lasting = [name for name, one in self._problems.items() if one.has_changed(vehicle_id, name in found, now_s)]
        for name in lasting:
            self._report(vehicle_id, name, found.get(name))
        doubtful = [name for name in (_POSITION, _FIX) if self._problems[name].counts(vehicle_id)]
        member.position_problem = found.get(doubtful[0], member.position_problem) if doubtful else ""
        return any(name in found for name in lasting if name in (_POSITION, _FIX))

    def battery_silence_s(self, member: Member) -> float | None:
        """Return the seconds without a report of the battery of a vehicle that is heard; None where it has no meter."""
        battery_at_s, heard_since_s = member.state.battery_at_s, self._heard_since_s.get(member.vehicle_id)
        if battery_at_s is None or heard_since_s is None:
            return None
        return self._clock.now_s() - max(battery_at_s, heard_since_s)

    def _report(self, vehicle_id: int, name: str, problem: str | None) -> None:
        if problem is None:
            self._journal.notice(Severity.INFO, _GOOD_AGAIN[name], vehicle_id)
        elif name in (_POSITION, _FIX):
            text = f"{problem}. It is held, and its distance to others is uncertain: return it, or land it"
            self._journal.notice(Severity.CRITICAL, text, vehicle_id)
        else:
            self._journal.notice(Severity.WARNING, problem, vehicle_id)


def has_position(state: VehicleState) -> bool:
    """Return whether a vehicle reports nothing that puts its position in doubt as a whole."""
    return not state.estimator_problem and (state.gps_fix is None or state.gps_fix >= MIN_GPS_FIX)


def problems(state: VehicleState) -> dict[str, str]:
    """Return the present problems in words, by their names."""
    found: dict[str, str] = {}
    if state.estimator_problem:
        found[_POSITION] = state.estimator_problem
    if state.gps_fix is not None and state.gps_fix < MIN_GPS_FIX:
        found[_FIX] = "it has lost its 3D position fix"
    most_mps2 = MAX_VIBRATION_METRIC_MPS2 if state.autopilot == "px4" else MAX_VIBRATION_MPS2
    if state.vibration_mps2 is not None and state.vibration_mps2 > most_mps2:
        level = f"{state.vibration_mps2:.0f} m/s²"
        found[_VIBRATION] = f"vibration of {level}: its altitude may be wrong. Return it, and check its propellers"
    drift = None if state.link is None else state.link.clock_drift
    if drift is not None and abs(drift) > MAX_CLOCK_DRIFT:
        found[_CLOCK] = f"its clock drifts by {1e3 * drift:+.1f} ms per second: the poses of its images may be wrong"
    return found
