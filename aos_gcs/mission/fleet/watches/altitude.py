"""Monitors the heights of all vehicles in flight against what they have in common: satellites and the air.

Each vehicle flies by its own estimate of its height. Its satellite receiver and its barometer measure it once more.
What weather and satellites do is the same for all, so the difference between estimate and measurement is compared with
that of the others: one that moves away from theirs is an error of that vehicle's own, and it leaves the altitude layer
that it believes to be in.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import median
from typing import Final, TypeAlias

from aos_gcs.airspace.accuracy import CONFIDENCE, allowed_offset_m
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.datum import stands
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, Severity, VehicleState

_BAROMETER_M: Final = 0.4
"""Standard deviation of a barometer's height in flight: wind and rotors press on it."""
_SMOOTHING_S: Final = 5.0
"""Time over which differences are averaged."""
_SETTLED_S: Final = 10.0
"""Time of level flight after which an average counts."""
_LEVEL_MPS: Final = 0.5
"""Vertical speed below which a vehicle flies level: reports that are up to a second apart then belong together."""
_MEASURED_AGE_S: Final = 1.0
"""Age up to which a position is compared with what is measured now."""
_AHEAD_S: Final = 8.0
"""Time for which a height that drifts is thought ahead, where others keep clear of it: a flight to the next place."""
_GONE_FACTOR: Final = 0.5
"""Share of the limit below which a deviation counts as gone."""


class Reference(StrEnum):
    """Measurement of the height, beside the autopilot's own estimate."""

    SATELLITES = "its satellite receiver"
    BAROMETER = "its barometer"


_Settled: TypeAlias = dict[Reference, dict[int, tuple[float, float]]]
"""Average difference of each vehicle and what that errs by, in metres, by reference."""


@dataclass(slots=True)
class _Track:
    """What is known of one vehicle's references."""

    ground_m: dict[Reference, float] = field(default_factory=dict)
    """Each reference at the launch point."""
    difference_m: dict[Reference, float] = field(default_factory=dict)
    """Average of the estimated height minus that of each reference, in level flight."""
    lagging_m: dict[Reference, float] = field(default_factory=dict)
    """Average of these averages: it lags behind a drift twice as far, which shows how fast the height drifts."""
    level_s: float = 0.0

    def forget(self) -> None:
        """Begin new averages."""
        self.difference_m, self.lagging_m, self.level_s = {}, {}, 0.0

    def drifted_m(self, reference: Reference) -> float:
        """Return how much more than its average a difference will be soon, if it goes on as now (Brown's method)."""
        lag_m = self.difference_m[reference] - self.lagging_m[reference]
        return lag_m * (1.0 + _AHEAD_S / _SMOOTHING_S)


class AltitudeWatch:
    """Compares the vehicles' heights, and says which one is not where it believes to be."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._tracks: dict[int, _Track] = {}
        self._looked_at_s: float | None = None
        self._told: set[int] = set()

    def look(self, separation_m: float, layer_spacing_m: float) -> dict[int, str]:
        """Update all averages; return the reason to leave by vehicle, for those whose height is wrong.

        A height is wrong when it may bring the vehicle nearer to the next layer than the separation: half of what the
        spacing of the layers leaves besides gusts, and what the reference itself errs by.
        """
        now_s = self._clock.now_s()
        elapsed_s = 0.0 if self._looked_at_s is None else now_s - self._looked_at_s
        self._looked_at_s = now_s
        airborne = {member.vehicle_id: member for member in self._roster.airborne()}
        for member in self._roster.members():
            self._follow(member, member.vehicle_id in airborne, elapsed_s)
        most_m = allowed_offset_m(separation_m, layer_spacing_m)
        reasons: dict[int, str] = {}
        settled = self._settled(airborne)
        for member in self._roster.members():
            found = self._deviation(member, settled) if member.vehicle_id in airborne else None
            self._judge(member, found, most_m, reasons)
        return reasons

    def _settled(self, airborne: Mapping[int, Member]) -> _Settled:
        """Return the averages that count."""
        settled: _Settled = {reference: {} for reference in Reference}
        for vehicle_id, member in airborne.items():
            track = self._tracks[vehicle_id]
            if track.level_s >= _SETTLED_S:
                for reference, difference_m in track.difference_m.items():
                    settled[reference][vehicle_id] = difference_m, _error_m(member, reference)
        return settled

    def _follow(self, member: Member, is_airborne: bool, elapsed_s: float) -> None:
        """Take in what a vehicle reports now."""
        track = self._tracks.setdefault(member.vehicle_id, _Track())
        state = member.state
        if stands(state, member.last_command):
            track.ground_m = _measured_m(state)
            track.forget()
            return
        if not is_airborne or not state.armed or not self._roster.is_fresh(state.position_at_s):
            # It falls, lies somewhere or is not heard: it says nothing of the others' heights.
            track.forget()
            return
        if (self._roster.position_age_s(member) or 0.0) > _MEASURED_AGE_S:
            return
        position_enu_m, velocity_enu_mps = self._roster.position_enu_m(member), state.velocity_enu_mps
        if position_enu_m is None or member.home_enu_m is None or velocity_enu_mps is None:
            return
        if abs(velocity_enu_mps[2]) > _LEVEL_MPS:
            return
        track.level_s += elapsed_s
        height_m = float(position_enu_m[2] - member.home_enu_m[2])
        share = 1.0 - math.exp(-elapsed_s / _SMOOTHING_S)
        measured_m = _measured_m(state)
        for reference in track.ground_m.keys() & measured_m.keys():
            difference_m = height_m - (measured_m[reference] - track.ground_m[reference])
            average_m = track.difference_m.get(reference, difference_m)
            average_m += share * (difference_m - average_m)
            lagging_m = track.lagging_m.get(reference, average_m)
            track.difference_m[reference] = average_m
            track.lagging_m[reference] = lagging_m + share * (average_m - lagging_m)

    def _deviation(self, member: Member, settled: _Settled) -> tuple[float, float, Reference] | None:
        """Return the worst deviation from the others, what it errs by, and the reference; None while there is none.

        Vehicles whose height has been found wrong say nothing of the others'.
        """
        left_out = {member.vehicle_id, *self._told}
        found = []
        for reference, averages in settled.items():
            others = [other for vehicle_id, other in averages.items() if vehicle_id not in left_out]
            if others and member.vehicle_id in averages:
                difference_m, own_error_m = averages[member.vehicle_id]
                away_m = difference_m - median(other_m for other_m, _ in others)
                error_m = math.hypot(own_error_m, median(error_m for _, error_m in others))
                found.append((away_m, CONFIDENCE * error_m, reference))
        return max(found, key=lambda each: abs(each[0]) - each[1], default=None)

    def _judge(
        self, member: Member, found: tuple[float, float, Reference] | None, most_m: float, reasons: dict[int, str]
    ) -> None:
        if found is None:
            member.altitude_doubt_m = 0.0
            self._told.discard(member.vehicle_id)
            return
        away_m, error_m, reference = found
        limit_m = most_m + error_m
        is_wrong = abs(away_m) > limit_m or (
            member.vehicle_id in self._told and abs(away_m) > error_m + _GONE_FACTOR * most_m
        )
        soon_m = away_m + self._tracks[member.vehicle_id].drifted_m(reference)
        member.altitude_doubt_m = max(abs(away_m), abs(soon_m)) if is_wrong else 0.0
        if not is_wrong:
            self._told.discard(member.vehicle_id)
            return
        direction = "below" if away_m > 0.0 else "above"
        text = f"it flies {abs(away_m):.1f} m {direction} the height that it reports, by {reference} and the others"
        reasons[member.vehicle_id] = text
        if member.vehicle_id not in self._told:
            self._told.add(member.vehicle_id)
            self._journal.notice(Severity.CRITICAL, f"wrong altitude: {text}. It leaves the swarm", member.vehicle_id)


def _measured_m(state: VehicleState) -> dict[Reference, float]:
    """Return the altitude that each reference of a vehicle measures."""
    measured_m: dict[Reference, float] = {}
    if state.gps_altitude_amsl_m is not None:
        measured_m[Reference.SATELLITES] = state.gps_altitude_amsl_m
    if state.pressure_hpa is not None:
        # The standard atmosphere; near the ground its errors are some per cent of the height, the same for all.
        measured_m[Reference.BAROMETER] = 44330.77 * (1.0 - (state.pressure_hpa / 1013.25) ** (1.0 / 5.25588))
    return measured_m


def _error_m(member: Member, reference: Reference) -> float:
    if reference is Reference.BAROMETER:
        return _BAROMETER_M
    return accuracy_of(member.state).vertical_m
