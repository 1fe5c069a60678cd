"""Lines of the plan's aperture and of its prior in the preflight matrix."""

from __future__ import annotations

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.checks.prior_check import WHOLE
from aos_gcs.planning.detection.aperture import advise
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.prior.file import prior_over


def check_aperture(settings: MissionSettings) -> tuple[PreflightCheck, ...]:
    """Return the check of the aperture, or none without a forest. It warns, but never blocks the launch."""
    if settings.forest is None:
        return ()
    advice = advise(settings, settings.forest)
    if not advice.warnings:
        return (checks.passed(checks.MISSION, checks.APERTURE, advice.text),)
    return (checks.warned(checks.MISSION, checks.APERTURE, advice.seen, "; ".join(advice.warnings)),)


def check_prior(settings: MissionSettings, origin: GeodeticPosition) -> tuple[PreflightCheck, ...]:
    """Return the check of the prior against the search area, or none without a prior.

    Args:
        settings: settings of the mission, with a search area.
        origin: origin of its frame.
    """
    name = settings.search.prior
    if name is None:
        return ()
    try:
        share = prior_over(name, origin, settings.area_enu_m).share
    except (ConfigurationError, InputDataError) as error:
        return (checks.failed(checks.MISSION, checks.PRIOR, str(error), "correct the prior's file, or remove it"),)
    text = f"{share:.0%} of the probability lies in the search area"
    if share < WHOLE:
        return (checks.warned(checks.MISSION, checks.PRIOR, text, "extend the area, or search elsewhere as well"),)
    return (checks.passed(checks.MISSION, checks.PRIOR, text),)
