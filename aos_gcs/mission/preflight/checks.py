"""Names of the preflight checks, and functions that fill in one cell of the matrix."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck

MISSION: Final = 0
"""Vehicle id of checks of the mission as a whole."""

PLAN: Final = "plan"
VEHICLES: Final = "vehicles"
AUTOPILOT: Final = "autopilot"
SYSTEM_ID: Final = "system id"
LINK: Final = "link"
CLOCK: Final = "clock"
POSITION: Final = "position"
HOME: Final = "home"
LAUNCH_POINT: Final = "launch point"
PATH: Final = "path to the area"
TERRAIN: Final = "terrain"
PRIOR: Final = "prior"
APERTURE: Final = "aperture"
ALTITUDE_LAYER: Final = "altitude layer"
DESCENT: Final = "descent at home"
HOME_ALTITUDE: Final = "home altitude"
ALTITUDE_ACCURACY: Final = "altitude accuracy"
BATTERY: Final = "battery"
READY_TO_ARM: Final = "ready to arm"
FIRMWARE: Final = "firmware"
GEOFENCE: Final = "geofence"
LINK_LOSS: Final = "link-loss failsafe"
LOW_BATTERY: Final = "battery failsafe"
ARMING_CHECKS: Final = "arming checks"
OTHER_FAILSAFES: Final = "other failsafes"
RETURN_PLACE: Final = "return place"
RETURN_HEIGHT: Final = "return height"
RETURN_CLIMB: Final = "climb of the return"
CAMERA: Final = "camera"

ORDER: Final = (
    AUTOPILOT,
    FIRMWARE,
    SYSTEM_ID,
    LINK,
    CLOCK,
    POSITION,
    HOME,
    LAUNCH_POINT,
    PATH,
    TERRAIN,
    ALTITUDE_LAYER,
    DESCENT,
    HOME_ALTITUDE,
    ALTITUDE_ACCURACY,
    BATTERY,
    READY_TO_ARM,
    GEOFENCE,
    LINK_LOSS,
    LOW_BATTERY,
    OTHER_FAILSAFES,
    ARMING_CHECKS,
    RETURN_PLACE,
    RETURN_HEIGHT,
    RETURN_CLIMB,
    CAMERA,
)
"""Order of the columns of the matrix."""

OVERRIDABLE: Final = frozenset(
    {
        HOME_ALTITUDE,
        ALTITUDE_ACCURACY,
        BATTERY,
        GEOFENCE,
        LINK_LOSS,
        LOW_BATTERY,
        OTHER_FAILSAFES,
        ARMING_CHECKS,
        RETURN_PLACE,
        RETURN_HEIGHT,
        RETURN_CLIMB,
        CAMERA,
    }
)
"""Checks that an operator may override. Without the others a vehicle cannot fly, or endangers its neighbours."""


def passed(vehicle_id: int, name: str, text: str) -> PreflightCheck:
    """Return a check that passes."""
    return PreflightCheck(vehicle_id, name, CheckStatus.PASS, text)


def warned(vehicle_id: int, name: str, text: str, remedy: str) -> PreflightCheck:
    """Return a check that warns."""
    return PreflightCheck(vehicle_id, name, CheckStatus.WARN, text, remedy)


def failed(vehicle_id: int, name: str, text: str, remedy: str) -> PreflightCheck:
    """Return a check that blocks the launch."""
    return PreflightCheck(vehicle_id, name, CheckStatus.FAIL, text, remedy, overridable=name in OVERRIDABLE)


def in_order(found: Iterable[PreflightCheck]) -> tuple[PreflightCheck, ...]:
    """Return checks by vehicle and column; those of the mission come first."""
    columns = {name: column for column, name in enumerate(ORDER)}
    return tuple(sorted(found, key=lambda check: (check.vehicle_id, columns.get(check.name, -1))))
