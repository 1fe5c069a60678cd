"""The prior and the segments of a search: whether they can be used for a plan, and what lies outside of its area."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.planning.plan import MissionPlan, PlanProblem
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.prior.file import prior_over, read_prior
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import segments_about

WHOLE: Final = 0.99
"""Share of the prior in the search area from which nothing is said of what lies outside."""


def plan_prior(plan: MissionPlan, settings: MissionSettings, origin: GeodeticPosition | None) -> AreaPrior | None:
    """Return the prior within a plan's area; None where there is none, or the origin is not known.

    Args:
        plan: its area is not empty.
        settings: settings of the mission that is to fly it.
        origin: origin of the plan, where the settings have none.

    Raises:
        ConfigurationError: a library is missing.
        InputDataError: the file cannot be used, or does not meet the area.
    """
    origin, name = settings.origin or origin, settings.search.prior
    if name is None or origin is None or not plan.area_enu_m:
        return None
    return prior_over(name, origin, plan.area_enu_m)


def check_prior(plan: MissionPlan, settings: MissionSettings, origin: GeodeticPosition | None) -> Iterator[PlanProblem]:
    """Yield why prior or segments cannot be used for a plan, and what of them lies outside of the area."""
    yield from _check_segments(plan, settings, origin)
    if settings.search.prior is None:
        return
    try:
        read_prior(settings.search.prior)
        prior = plan_prior(plan, settings, origin)
    except (ConfigurationError, InputDataError) as error:
        yield PlanProblem("area_enu_m", f"Prior: {error}")
        return
    if prior is not None and prior.share < WHOLE:
        yield PlanProblem("area_enu_m", outside_warning(prior), blocking=False)


def outside_warning(prior: AreaPrior) -> str:
    """Return what operators are told where part of the prior lies outside of the search area."""
    return (
        f"{1.0 - prior.share:.0%} of the prior probability lies outside of the search area: extend the "
        "area, or search there by other means."
    )


def _check_segments(
    plan: MissionPlan, settings: MissionSettings, origin: GeodeticPosition | None
) -> Iterator[PlanProblem]:
    origin, name = settings.origin or origin, settings.search.segments
    if name is None or origin is None:
        return
    try:
        segments = segments_about(name, origin)
    except InputDataError as error:
        yield PlanProblem("area_enu_m", f"Segments: {error}")
        return
    raster = PlanRaster.around(plan.area_enu_m)
    area = raster.inside([plan.area_enu_m])
    outside = [one.name for one in segments if not (area & raster.inside([one.area_enu_m])).any()]
    if len(outside) == len(segments):
        text = f"No segment of {name} meets the search area: correct the file, or remove it."
        yield PlanProblem("area_enu_m", text)
    elif outside:
        text = f"Segments outside of the search area, which are not searched: {', '.join(outside)}. Extend the area."
        yield PlanProblem("area_enu_m", text, blocking=False)
