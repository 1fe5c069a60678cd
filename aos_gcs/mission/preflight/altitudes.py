"""Preflight checks of altitudes: altitude layers keep vehicles apart only where their heights agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median
from typing import Final

from aos_gcs.airspace.accuracy import CONFIDENCE, allowed_offset_m, greatest_accuracy_m, needed_spacing_m
from aos_gcs.mission.fleet.datum import RTK_FIXED, home_altitude_m, standing_altitude_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.telemetry import GPS_FIXES
from aos_gcs.planning.checks.advice import MIN_LAYERS_WITHOUT_RTK_M

MAX_TEST_RATIO: Final = 0.8
"""Test ratio of the altitude from which an estimator is in doubt; ArduPilot's own failsafe acts there."""


def check_altitudes(
    roster: Roster, members: Sequence[Member], separation_m: float, layer_spacing_m: float
) -> list[PreflightCheck]:
    """Return for every vehicle whether its home agrees with those of the others, and its altitude is accurate enough.

    Args:
        roster: the vehicles heard.
        members: those that are to fly.
        separation_m: smallest distance between two vehicles.
        layer_spacing_m: vertical distance between altitude layers.
    """
    homes_m = _heights_of_homes_m(roster, members)
    # Where a difference is no error but a slope, layers still keep their vehicles apart by the separation.
    most_m = allowed_offset_m(separation_m, layer_spacing_m)
    return [
        check
        for member in members
        for check in (
            _check_home(member.vehicle_id, homes_m, most_m),
            _check_accuracy(member, separation_m, layer_spacing_m),
        )
    ]


def _heights_of_homes_m(roster: Roster, members: Sequence[Member]) -> dict[int, float]:
    """Return how high each home is reported above the ground that preflight has surveyed, by vehicle.

    Of a vehicle that stands on the ground, that is the home which it will have as soon as it is armed.
    """
    heights_m = {}
    for member in members:
        home_m = None if member.state.home is None else standing_altitude_m(member.state)
        if home_m is None:
            home_m = home_altitude_m(member.state)
        if home_m is not None:
            ground_m = 0.0 if roster.ground is None else roster.ground.altitude_amsl_m(member.vehicle_id)
            heights_m[member.vehicle_id] = home_m - ground_m
    return heights_m


def _check_home(vehicle_id: int, homes_m: Mapping[int, float], most_m: float) -> PreflightCheck:
    home_m = homes_m.get(vehicle_id)
    if home_m is None:
        return checks.failed(vehicle_id, checks.HOME_ALTITUDE, "unknown", "wait for the position estimate")
    others_m = [other_m for other_id, other_m in homes_m.items() if other_id != vehicle_id]
    if not others_m:
        return checks.passed(vehicle_id, checks.HOME_ALTITUDE, "alone")
    away_m = home_m - median(homes_m.values())
    text = f"{abs(away_m):.1f} m {'above' if away_m > 0.0 else 'below'} the median of all"
    if abs(away_m) > most_m:
        remedy = (
            f"{most_m:.1f} m are allowed: restart it where the sky is open, place all on level ground, use RTK, or "
            "widen the layer spacing"
        )
        return checks.failed(vehicle_id, checks.HOME_ALTITUDE, text, remedy)
    return checks.passed(vehicle_id, checks.HOME_ALTITUDE, text)


def _check_accuracy(member: Member, separation_m: float, layer_spacing_m: float) -> PreflightCheck:
    vehicle_id, state = member.vehicle_id, member.state
    accuracy_m, ratio = state.vertical_accuracy_m, state.altitude_test_ratio
    fix = "fix unknown" if state.gps_fix is None else GPS_FIXES.get(state.gps_fix, f"GPS fix {state.gps_fix}")
    if accuracy_m is None:
        remedy = "send MAVLink 2, so that its receiver can say how accurate it is"
        return checks.failed(vehicle_id, checks.ALTITUDE_ACCURACY, f"not reported, {fix}", remedy)
    text = f"± {CONFIDENCE * accuracy_m:.2f} m (95 %), {fix}"
    wider = f"set the layer spacing to {needed_spacing_m(separation_m, accuracy_m):.1f} m or more"
    if ratio is not None and ratio >= MAX_TEST_RATIO:
        text += f", estimator in doubt ({ratio:.0%} of what it accepts)"
        return checks.failed(vehicle_id, checks.ALTITUDE_ACCURACY, text, "restart it where the sky is open")
    if accuracy_m > greatest_accuracy_m(separation_m, layer_spacing_m):
        remedy = f"layers of {layer_spacing_m:g} m need better: wait for corrections, or {wider}"
        return checks.failed(vehicle_id, checks.ALTITUDE_ACCURACY, text, remedy)
    if layer_spacing_m < MIN_LAYERS_WITHOUT_RTK_M and state.gps_fix != RTK_FIXED:
        remedy = (
            f"layers of {layer_spacing_m:g} m need an RTK fix: wait for corrections, or set the layer spacing to "
            f"{MIN_LAYERS_WITHOUT_RTK_M:g} m or more"
        )
        return checks.failed(vehicle_id, checks.ALTITUDE_ACCURACY, text, remedy)
    return checks.passed(vehicle_id, checks.ALTITUDE_ACCURACY, text)
