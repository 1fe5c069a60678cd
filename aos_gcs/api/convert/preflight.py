"""Conversion of preflight checks."""

from __future__ import annotations

from aos_gcs.api.models.preflight import OverrideModel, PreflightCheckModel
from aos_gcs.mission.model.checks import PreflightCheck


def preflight_check(check: PreflightCheck) -> PreflightCheckModel:
    """Convert one cell of the matrix."""
    override = check.overridden
    return PreflightCheckModel(
        vehicle_id=check.vehicle_id,
        name=check.name,
        status=check.status,
        text=check.text,
        remedy=check.remedy,
        overridable=check.overridable,
        overridden=OverrideModel(reason=override.reason, by=override.by, utc_s=override.utc_s) if override else None,
        blocks=check.blocks,
    )
