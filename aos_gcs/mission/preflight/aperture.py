"""The aperture's line in the preflight matrix."""

from __future__ import annotations

from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.aperture import advise
from aos_gcs.planning.settings import MissionSettings

CHECK_NAME = "aperture"


def check_aperture(settings: MissionSettings) -> tuple[PreflightCheck, ...]:
    """Return the check of the aperture, or none without a forest. It warns, but never blocks the launch."""
    if settings.forest is None:
        return ()
    advice = advise(settings, settings.forest)
    if not advice.warnings:
        return (checks.passed(checks.MISSION, CHECK_NAME, advice.text),)
    return (checks.warned(checks.MISSION, CHECK_NAME, advice.seen, "; ".join(advice.warnings)),)
