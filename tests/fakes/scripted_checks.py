"""Preflight checks of the scripted mission."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight.checks import DESCENT, MISSION, VEHICLES, failed, passed, warned
from tests.fakes.scripted_vehicle import SILENT_ID

PROPOSED = 3
"""Vehicles of the plan while none is confirmed."""
_NAMES = ("link", "position", "battery", "home", "camera")


def scripted_checks(vehicle_ids: Sequence[int], *, is_confirmed: bool, warning: str) -> list[PreflightCheck]:
    """Return the checks: one vehicle was never heard; the first one has a warning where a text is given."""
    checks = [
        failed(vehicle_id, name, "never heard", "check its power and radio")
        if vehicle_id == SILENT_ID
        else passed(vehicle_id, name, "within limits")
        for vehicle_id in vehicle_ids
        for name in _NAMES
    ]
    if warning:
        checks.append(warned(1, DESCENT, warning, "place them side by side"))
    if not is_confirmed:
        checks = [check for check in checks if check.vehicle_id != SILENT_ID]
        checks.append(failed(MISSION, VEHICLES, f"{PROPOSED} planned", "confirm the vehicles that fly"))
    return checks
