"""Advice on a plan that can be flown: what may end its search early, leave gaps, or need permission."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from aos_gcs.airspace.accuracy import needed_spacing_m
from aos_gcs.airspace.polygon import as_polygon, signed_depth_m
from aos_gcs.airspace.stopping import StoppingDistance
from aos_gcs.planning.checks.advice import MIN_LAYERS_WITHOUT_RTK_M
from aos_gcs.planning.estimate import PlanEstimate
from aos_gcs.planning.plan import MissionPlan, PlanProblem
from aos_gcs.planning.proposal import fence_margin_m

GOOD_COVERAGE = 0.95
USUAL_CEILING_M = 120.0
"""Height above the ground that most countries allow uncrewed aircraft."""

_POD_TOLERANCE = 0.01
"""Shortfall of a predicted probability of detection that is within its own error."""
_ROUNDING_M = 0.1
"""Margins are entered with one decimal."""


def plan_warnings(plan: MissionPlan, estimate: PlanEstimate, separation_m: float) -> Iterator[PlanProblem]:
    """Yield what a plan that can be flown would better not do; vehicles keep a separation of ``separation_m``."""
    yield from _warn_of_layers(plan, separation_m)
    yield from _warn_of_flight(plan, estimate)
    yield from _warn_of_margin(plan)


def _warn_of_layers(plan: MissionPlan, separation_m: float) -> Iterator[PlanProblem]:
    least_m = needed_spacing_m(separation_m, 0.0)
    if plan.vehicles > 1 and plan.layer_spacing_m < least_m:
        text = (
            f"Layers of {plan.layer_spacing_m:g} m fail preflight: with a separation of {separation_m:g} m they leave "
            f"no room for gusts; {least_m:g} m and more do where heights are known by RTK."
        )
        yield PlanProblem("layer_spacing_m", text, blocking=False)
    elif plan.layer_spacing_m < MIN_LAYERS_WITHOUT_RTK_M:
        text = (
            f"Layers of {plan.layer_spacing_m:g} m need heights known by RTK; without it, "
            f"{MIN_LAYERS_WITHOUT_RTK_M:g} m and more are safe."
        )
        yield PlanProblem("layer_spacing_m", text, blocking=False)


def _warn_of_flight(plan: MissionPlan, estimate: PlanEstimate) -> Iterator[PlanProblem]:
    if plan.vehicles == 1:
        yield PlanProblem(
            "vehicles",
            "A single vehicle looks closer by visiting places around what it has seen, one after the other; the "
            "strategy is for two and more.",
            blocking=False,
        )
    highest_m = plan.highest_layer_m
    if highest_m > USUAL_CEILING_M:
        yield PlanProblem(
            "ceiling_m",
            f"The highest layer is at {highest_m:g} m; most countries allow {USUAL_CEILING_M:g} m above the ground "
            "without a permission: lower the layers or their spacing, or fly fewer vehicles.",
            blocking=False,
        )
    if estimate.covered_fraction < GOOD_COVERAGE:
        yield PlanProblem(
            "area_enu_m",
            f"The legs sweep {estimate.covered_fraction:.0%} of the search area; the rest lies in no-go zones, "
            "beside the legs, or between them on high ground, where the swath is narrower.",
            blocking=False,
        )
    if plan.pod is not None and (text := _why_below(plan, plan.pod, estimate)):
        yield PlanProblem("pod", text, blocking=False)
    if estimate.flight_s > plan.search_s:
        yield PlanProblem(
            "search_s",
            f"The flight takes {estimate.flight_s / 60.0:.0f} min, but all vehicles return after "
            f"{plan.search_s / 60.0:.0f} min: the search ends before its last leg; allow more time, or make the area "
            "smaller.",
            blocking=False,
        )
    left = 1.0 - plan.min_battery_fraction
    if estimate.battery_fraction > left:
        yield PlanProblem(
            "endurance_s",
            f"The flight takes {estimate.battery_fraction:.0%} of a battery, and the reserve leaves {left:.0%}: the "
            "search ends before its last leg; use a smaller area or more vehicles.",
            blocking=False,
        )


def _why_below(plan: MissionPlan, pod: float, estimate: PlanEstimate) -> str:
    """Return why the legs do not reach the wanted probability of detection, or are not known to; empty if they do."""
    if plan.forest is None:
        return "Describe the forest: without it nobody knows which probability of detection the legs reach."
    if estimate.detection is None:
        return "The probability of detection is predicted for searches in flight only."
    if estimate.detection.standing >= pod - _POD_TOLERANCE:
        return ""
    return (
        f"The legs reach a probability of detection of {estimate.detection.standing:.0%} for a standing person, "
        f"{pod:.0%} are wanted: use the suggested spacings and speed; where there are none, fly more vehicles, or want "
        "less."
    )


def _warn_of_margin(plan: MissionPlan) -> Iterator[PlanProblem]:
    stopping = StoppingDistance(plan.cruise_speed_mps)
    margin_m = fence_margin_m(plan.fence_margin_m, plan.cruise_speed_mps)
    if margin_m < stopping.total_m - _ROUNDING_M:
        text = (
            f"With a margin of {margin_m:g} m a vehicle at full speed may stop outside of the geofence: it needs "
            f"{stopping}. Leave the margin empty, or fly slower."
        )
        yield PlanProblem("fence_margin_m", text, blocking=False)
    if plan.fence_enu_m is None:
        return
    fence_m = as_polygon(plan.fence_enu_m, "fence_enu_m")
    nearest_m = min(signed_depth_m(np.array(corner_m), fence_m) for corner_m in plan.area_enu_m)
    if nearest_m < margin_m:
        text = (
            f"The search area comes within {max(nearest_m, 0.0):.0f} m of the geofence, whose margin is "
            f"{margin_m:.1f} m: vehicles do not fly above what lies in the margin. Widen the geofence, fly slower, or "
            "lower the margin."
        )
        yield PlanProblem("fence_enu_m", text, blocking=False)
