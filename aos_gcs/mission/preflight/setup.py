"""Preflight checks of every vehicle's settings, geofence and camera, from its inspection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.inspection import Inspection
from aos_gcs.ports import Safeguard, VehicleFacts, VehicleState

MIN_BELOW_HORIZON_RAD = math.radians(45.0)
"""Smallest angle of a camera: one that looks further up sees little of the forest's ground."""

_SAFEGUARDS: Mapping[str, Callable[[VehicleFacts], Safeguard]] = MappingProxyType(
    {
        checks.LINK_LOSS: lambda facts: facts.link_loss,
        checks.LOW_BATTERY: lambda facts: facts.low_battery,
        checks.OTHER_FAILSAFES: lambda facts: facts.other_failsafes,
        checks.ARMING_CHECKS: lambda facts: facts.arming_checks,
        checks.RETURN_PLACE: lambda facts: facts.return_place,
    }
)
"""Safeguards that an autopilot has to have, by the name of their check."""
_SLACK_M = 0.1
"""Tolerance of heights: autopilots round what they store."""


@dataclass(frozen=True, slots=True)
class ReturnBounds:
    """Heights above home between which a vehicle's own return has to be."""

    layer_m: float | None
    """Height of its altitude layer, which it must not leave upwards; None while that is not known."""
    least_m: float | None = None
    """Smallest height; None where the ground counts as level."""
    least_of: str = ""
    """What decides the smallest height."""


def check_setup(state: VehicleState, inspection: Inspection, bounds: ReturnBounds) -> list[PreflightCheck]:
    """Return the checks of one vehicle's settings, fence and camera.

    Args:
        state: telemetry of the vehicle.
        inspection: its answers so far.
        bounds: heights of its own return.
    """
    vehicle_id, facts = state.vehicle_id, inspection.facts
    if facts is None:
        names = (checks.FIRMWARE, checks.GEOFENCE, *_SAFEGUARDS, checks.RETURN_HEIGHT)
        unknown = [_unknown(vehicle_id, name, inspection.problem) for name in names]
        return [*unknown, _check_camera(state, inspection)]
    return [
        _check_firmware(state, facts.firmware),
        _check_fence(vehicle_id, inspection),
        *(_check_safeguard(vehicle_id, name, safeguard_of(facts)) for name, safeguard_of in _SAFEGUARDS.items()),
        _check_return_height(vehicle_id, facts, inspection, bounds),
        _check_camera(state, inspection),
    ]


def check_system_ids(states: Iterable[VehicleState], board_ids: Mapping[int, str]) -> list[PreflightCheck]:
    """Return for every vehicle whether its system id is unique, by the addresses and boards that it is heard from.

    Args:
        states: the vehicles' telemetry.
        board_ids: ids of the flight controllers, by vehicle; empty where not known.
    """
    return [_check_system_id(state, board_ids) for state in states]


def _check_system_id(state: VehicleState, board_ids: Mapping[int, str]) -> PreflightCheck:
    vehicle_id, board_id = state.vehicle_id, board_ids.get(state.vehicle_id, "")
    if state.is_ambiguous:
        return checks.failed(vehicle_id, checks.SYSTEM_ID, "two vehicles use it", "give one of them another id")
    twins = [other for other, other_board_id in board_ids.items() if other != vehicle_id and other_board_id == board_id]
    if board_id and twins:
        text = f"its board has the same id as that of vehicle {twins[0]}"
        remedy = "normal for simulators; with real vehicles, check whether one is heard under two ids"
        return checks.warned(vehicle_id, checks.SYSTEM_ID, text, remedy)
    return checks.passed(vehicle_id, checks.SYSTEM_ID, f"its own, board {board_id[:16]}" if board_id else "its own")


def _unknown(vehicle_id: int, name: str, problem: str) -> PreflightCheck:
    """Return a check that waits for an answer; it cannot be overridden before the vehicle could answer."""
    if not problem:
        status = CheckStatus.FAIL if name in checks.OVERRIDABLE else CheckStatus.WARN
        return PreflightCheck(vehicle_id, name, status, "not known yet", "wait: the vehicle is being inspected")
    make = checks.failed if name in checks.OVERRIDABLE else checks.warned
    return make(vehicle_id, name, "not known", problem)


def _check_firmware(state: VehicleState, firmware: str) -> PreflightCheck:
    if not firmware:
        return checks.warned(state.vehicle_id, checks.FIRMWARE, "not reported", "check it in another ground station")
    return checks.passed(state.vehicle_id, checks.FIRMWARE, f"{state.autopilot} {firmware}")


def _check_fence(vehicle_id: int, inspection: Inspection) -> PreflightCheck:
    facts, planned = inspection.facts, inspection.planned_fence
    stored = None if facts is None else facts.fence
    if facts is None or planned is None:
        return PreflightCheck(
            vehicle_id, checks.GEOFENCE, CheckStatus.FAIL, "not planned yet", "wait until all homes are known"
        )
    if inspection.upload_problem:
        return checks.failed(vehicle_id, checks.GEOFENCE, "upload failed", inspection.upload_problem)
    if not inspection.has_planned_fence:
        text = "none" if stored is None else "not the mission's"
        if inspection.may_upload:
            wait = "wait: the mission's is being uploaded"
            return PreflightCheck(vehicle_id, checks.GEOFENCE, CheckStatus.FAIL, text, wait)
        remedy = "upload it with another ground station, or allow this station to upload geofences"
        return checks.failed(vehicle_id, checks.GEOFENCE, text, remedy)
    if not facts.at_fence.is_on:
        return checks.failed(vehicle_id, checks.GEOFENCE, f"not enforced: {facts.at_fence.text}", facts.at_fence.remedy)
    corners = len(planned.inclusion_deg) + sum(map(len, planned.exclusions_deg))
    limits = f"{corners} corners, up to {planned.ceiling_above_home_m:g} m"
    return checks.passed(vehicle_id, checks.GEOFENCE, f"as planned, {limits}: {facts.at_fence.text}")


def _check_safeguard(vehicle_id: int, name: str, safeguard: Safeguard) -> PreflightCheck:
    if safeguard.is_on:
        return checks.passed(vehicle_id, name, safeguard.text)
    return checks.failed(vehicle_id, name, safeguard.text, safeguard.remedy)


def _check_return_height(
    vehicle_id: int, facts: VehicleFacts, inspection: Inspection, bounds: ReturnBounds
) -> PreflightCheck:
    """Check that a failsafe return stays in the vehicle's own layer, and clears the ground.

    One that climbs crosses the layers of others; one that is lower than the hills on its way flies into them.
    """
    name, text = checks.RETURN_HEIGHT, f"{facts.return_height_m:g} m"
    if facts.return_climb_m > 0.0:
        text += f", and {facts.return_climb_m:g} m above where it is"
    if inspection.return_problem:
        return checks.failed(vehicle_id, name, f"{text}, change refused", inspection.return_problem)
    if not inspection.has_wanted_return:
        return PreflightCheck(vehicle_id, name, CheckStatus.FAIL, text, "wait: the height of its layer is being set")
    layer_m, least_m = bounds.layer_m, bounds.least_m
    if layer_m is not None and (facts.return_height_m > layer_m + _SLACK_M or facts.return_climb_m > 0.0):
        remedy = f"it would climb through other layers: {_set_return_height(facts, bounds)}"
        return checks.failed(vehicle_id, name, text, remedy)
    if least_m is not None and facts.return_height_m < least_m - _SLACK_M:
        missing_m = least_m - facts.return_height_m
        text += f", {missing_m:.1f} m below {bounds.least_of}"
        return checks.failed(vehicle_id, name, text, _set_return_height(facts, bounds))
    return checks.passed(vehicle_id, name, text)


def _set_return_height(facts: VehicleFacts, bounds: ReturnBounds) -> str:
    """Return how to set a return height within its bounds."""
    settings, layer_m, least_m = ", ".join(facts.return_settings), bounds.layer_m, bounds.least_m
    if least_m is None:
        height = f"{layer_m:g} m, its layer, or less"
    elif layer_m is None:
        height = f"{least_m:.1f} m or more"
    elif least_m > layer_m + _SLACK_M:
        return f"raise the layers by {least_m - layer_m:.1f} m: this one does not clear the ground on the way home"
    elif least_m == layer_m:
        height = f"{layer_m:.1f} m"
    else:
        height = f"between {least_m:.1f} m and {layer_m:g} m, its layer"
    return f"set it with another ground station ({settings}) to {height}, or allow this station to set return heights"


def _check_camera(state: VehicleState, inspection: Inspection) -> PreflightCheck:
    vehicle_id, frame = state.vehicle_id, inspection.frame
    if frame is None:
        if inspection.frame_problem:
            return checks.failed(vehicle_id, checks.CAMERA, "no frame", inspection.frame_problem)
        wait = "wait: a test frame is being captured"
        return PreflightCheck(vehicle_id, checks.CAMERA, CheckStatus.FAIL, "no frame yet", wait)
    text = f"{frame.width_px} x {frame.height_px}, {' '.join(frame.bands)}"
    if not frame.is_rotation:
        return checks.failed(vehicle_id, checks.CAMERA, f"{text}, no orientation", "check how the camera is mounted")
    distance_m = frame.distance_m(state)
    text += f", {math.degrees(frame.below_horizon_rad):.0f}° below the horizon"
    text += "" if distance_m is None else f", {distance_m:.1f} m from the vehicle"
    if not frame.is_plausible(state):
        remedy = "its pose is wrong: check the camera's clock and where its positions come from"
        return checks.failed(vehicle_id, checks.CAMERA, text, remedy)
    if frame.below_horizon_rad < MIN_BELOW_HORIZON_RAD:
        return checks.warned(vehicle_id, checks.CAMERA, text, "point it down: it hardly sees the ground")
    return checks.passed(vehicle_id, checks.CAMERA, text)
