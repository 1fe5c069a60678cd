"""Checks of a plan: all problems at once, each with the field to change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.polygon import Polygon, as_polygon, contains, edges_met
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.errors import ConfigurationError, ParameterError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.step.settings import MAX_RATE_HZ
from aos_gcs.planning.checks.advice import forest_aperture
from aos_gcs.planning.checks.plan_warnings import plan_warnings
from aos_gcs.planning.checks.prior_check import check_prior, plan_prior
from aos_gcs.planning.checks.sites import Homes, check_paths, check_points, planned_ground
from aos_gcs.planning.detection.expected_views import MOST_EXPOSURES, exposures_of_places
from aos_gcs.planning.estimate import PlanEstimate, launch_place, planned_leg_count, planned_legs
from aos_gcs.planning.leg_order import chances_of, exposures_of_a_pass, order_legs
from aos_gcs.planning.legs import ScanLeg, in_passes
from aos_gcs.planning.plan import SPACING_PARAMETER, MissionPlan, PlanProblem, apply_plan
from aos_gcs.planning.search_settings import GREATEST_POD, LEAST_POD, MAX_LINE_SPACING_M, MAX_PASSES, SearchMode
from aos_gcs.planning.settings import (
    GREATEST_FLIGHT_SETTINGS,
    LEAST_FLIGHT_SETTINGS,
    MAX_HEIGHT_M,
    MissionSettings,
)
from aos_gcs.planning.terrain.check import check_terrain
from aos_gcs.planning.terrain.relief_estimate import estimate_over_ground
from aos_gcs.swarm.declaration import Parameter
from aos_gcs.swarm.registry import declared_parameters, make_strategy

MAX_EXTENT_M = 5000.0
"""Greatest distance of an area from the origin: beyond it the local frame's axes no longer stand upright."""
SWAPPED_FROM_M = 100_000.0
"""Distance from which coordinates are taken to be swapped: no plan is made for a place so far away."""
MIN_FREE_FRACTION = 0.02
"""Share of the search area that no-go zones must leave free."""
MAX_VERTICES = 500
"""Greatest number of corners of a polygon, as edges are compared in pairs."""
MAX_BARRIER_VERTICES = 200
"""Greatest number of corners of geofence and no-go zones together, as paths around them are searched in flight."""
MAX_LEGS = 100
"""Greatest number of legs: far more than batteries last for."""

OUT_OF_MEMORY = (
    "Checking this plan takes more memory than the station has: make the search area smaller, or use fewer vehicles or "
    "fewer frames per second."
)

_DAY_S = 86_400.0
_POSITIVE = (
    "lowest_layer_m",
    "layer_spacing_m",
    "cruise_speed_mps",
    "search_speed_mps",
    "rate_hz",
    "endurance_s",
    "search_s",
)
_GREATEST = {
    **GREATEST_FLIGHT_SETTINGS,
    "rate_hz": MAX_RATE_HZ,
    "endurance_s": _DAY_S,
    "search_s": _DAY_S,
    "fence_margin_m": MAX_EXTENT_M,
    "spacing_m": MAX_EXTENT_M,
    "line_spacing_m": MAX_LINE_SPACING_M,
    "leg_spacing_m": MAX_LINE_SPACING_M,
}
"""Greatest values of fields in their units."""

_NAMES = {"area_enu_m": "The search area", "fence_enu_m": "The geofence"}


@dataclass(frozen=True, slots=True)
class PlanExamination:
    """What a check of a plan has found."""

    problems: tuple[PlanProblem, ...]
    """Problems, blocking ones first."""
    legs: tuple[ScanLeg, ...]
    """Legs of the plan; none while a shape or a number is wrong."""
    estimate: PlanEstimate | None
    """None while a problem is blocking."""


def check_plan(
    plan: MissionPlan,
    settings: MissionSettings,
    homes_enu_m: Homes | None = None,
    origin: GeodeticPosition | None = None,
) -> list[PlanProblem]:
    """Return the problems of a plan, blocking ones first.

    Args:
        plan: to be checked.
        settings: settings of the mission that is to fly it.
        homes_enu_m: launch points of the vehicles that are heard already.
        origin: origin of the plan, where the settings have none; without one the ground is not checked.
    """
    return list(examine_plan(plan, settings, homes_enu_m, origin).problems)


def examine_plan(
    plan: MissionPlan,
    settings: MissionSettings,
    homes_enu_m: Homes | None = None,
    origin: GeodeticPosition | None = None,
) -> PlanExamination:
    """Return the problems of a plan, as ``check_plan`` does, with its legs and its estimate."""
    try:
        return _examined(plan, settings, homes_enu_m or {}, origin)
    except MemoryError:
        return PlanExamination((PlanProblem("area_enu_m", OUT_OF_MEMORY),), (), None)


def _examined(
    plan: MissionPlan, settings: MissionSettings, homes_enu_m: Homes, origin: GeodeticPosition | None
) -> PlanExamination:
    estimate = None
    problems, legs = _problems(plan, settings, homes_enu_m, origin)
    if not _blocks(problems):
        chances = chances_of(plan, settings.imaging.plane_height_m, plan_prior(plan, settings, origin))
        legs = order_legs(legs, plan, chances, launch_place(plan))
        estimate = estimate_over_ground(plan, settings, origin, homes_enu_m, legs)
        problems += plan_warnings(plan, estimate, _separation_m(settings))
    return PlanExamination(tuple(sorted(problems, key=lambda problem: not problem.blocking)), legs, estimate)


def blocking_problems(plan: MissionPlan, settings: MissionSettings) -> list[PlanProblem]:
    """Return the problems for which a plan cannot be flown wherever the vehicles are: faster than ``check_plan``."""
    return [problem for problem in _problems(plan, settings, {}, None)[0] if problem.blocking]


def _problems(
    plan: MissionPlan, settings: MissionSettings, homes_enu_m: Homes, origin: GeodeticPosition | None
) -> tuple[list[PlanProblem], tuple[ScanLeg, ...]]:
    """Return the problems, and the legs where shapes and numbers allow any."""
    legs: tuple[ScanLeg, ...] = ()
    shapes = [*_check_shapes(plan), *_check_extent_of_points(plan)]
    problems = [*shapes, *_check_numbers(plan, settings)]
    if not shapes:
        ground = planned_ground(plan, homes_enu_m, settings.flight.arrival_radius_m)
        problems += [*_check_places(plan), *check_points(plan, ground, homes_enu_m)]
        if not _blocks(problems):
            problems += [*_check_limits(plan, settings), *_check_legs(plan, settings)]
        if not _blocks(problems):
            legs = planned_legs(plan, settings.imaging.plane_height_m)
            problems += check_paths(plan, ground, homes_enu_m, in_passes(legs, plan.passes))
            problems += check_terrain(plan, settings, origin, homes_enu_m, legs)
            problems += check_prior(plan, settings, origin)
    return problems, legs


def _blocks(problems: Sequence[PlanProblem]) -> bool:
    return any(problem.blocking for problem in problems)


# --- each shape by itself ---------------------------------------------------------------------------------------------


def _check_shapes(plan: MissionPlan) -> Iterator[PlanProblem]:
    shapes = {"area_enu_m": plan.area_enu_m}
    if plan.fence_enu_m is not None:
        shapes["fence_enu_m"] = plan.fence_enu_m
    shapes |= {f"no_go_enu_m[{index}]": zone for index, zone in enumerate(plan.no_go_enu_m)}
    for field, polygon_enu_m in shapes.items():
        name = _NAMES.get(field, "A no-go zone")
        if len(polygon_enu_m) > MAX_VERTICES:
            yield PlanProblem(field, f"{name} has {len(polygon_enu_m)} points; use {MAX_VERTICES} or fewer.")
            continue
        try:
            vertices_m = as_polygon(polygon_enu_m, name) if polygon_enu_m else None
        except ConfigurationError as error:
            yield PlanProblem(field, str(error))
            continue
        if vertices_m is None:
            yield PlanProblem(field, f"{name} is empty; draw it.")
        elif np.abs(vertices_m).max() > MAX_EXTENT_M:
            yield PlanProblem(field, f"{name} reaches to {_far(float(np.abs(vertices_m).max()))}")
    barriers = len(plan.fence_enu_m or ()) + sum(map(len, plan.no_go_enu_m))
    if barriers > MAX_BARRIER_VERTICES:
        text = f"Geofence and no-go zones have {barriers} points; simplify them to {MAX_BARRIER_VERTICES} in all."
        yield PlanProblem("no_go_enu_m", text)


def _check_extent_of_points(plan: MissionPlan) -> Iterator[PlanProblem]:
    for field, name in (("launch_enu_m", "launch"), ("return_enu_m", "return")):
        point_enu_m = getattr(plan, field)
        if point_enu_m is None:
            continue
        far_m = float(np.abs(np.array(point_enu_m)).max())
        if not far_m <= MAX_EXTENT_M:
            yield PlanProblem(field, f"The {name} point is {_far(far_m)}")


def _far(far_m: float) -> str:
    text = f"{far_m / 1000.0:.1f} km from the origin, {MAX_EXTENT_M / 1000.0:.0f} km are allowed: move it"
    return f"{text}." if far_m < SWAPPED_FROM_M else f"{text}; are latitude and longitude swapped?"


# --- shapes against one another ---------------------------------------------------------------------------------------


def _check_places(plan: MissionPlan) -> Iterator[PlanProblem]:
    fence_enu_m = plan.fence_enu_m
    if fence_enu_m is not None and not _is_within(plan.area_enu_m, fence_enu_m):
        yield PlanProblem("area_enu_m", "The search area leaves the geofence; shrink it, or widen it.")
    raster = PlanRaster.around(plan.area_enu_m)
    inside = raster.inside([plan.area_enu_m])
    free = inside & ~raster.inside(plan.no_go_enu_m)
    if np.count_nonzero(free) < MIN_FREE_FRACTION * np.count_nonzero(inside):
        yield PlanProblem("no_go_enu_m", "The no-go zones cover the whole search area; nothing is left to search.")


def _is_within(inner: Polygon, outer: Polygon) -> bool:
    """Return whether a polygon lies inside another one; their edges may touch."""
    inner_m, outer_m = as_polygon(inner, "inner"), as_polygon(outer, "outer")
    middle_m = inner_m.mean(axis=0)
    shrunk_m = middle_m + (inner_m - middle_m) * (1.0 - 1e-6)
    if not all(contains(vertex_m, outer_m) for vertex_m in shrunk_m):
        return False
    following_m = np.roll(shrunk_m, -1, axis=0)
    return not any(edges_met(start_m, end_m, outer_m) for start_m, end_m in zip(shrunk_m, following_m, strict=True))


# --- numbers ----------------------------------------------------------------------------------------------------------


def _check_numbers(plan: MissionPlan, settings: MissionSettings) -> Iterator[PlanProblem]:
    if not 1 <= plan.vehicles <= 250:
        yield PlanProblem("vehicles", f"A mission has 1 to 250 vehicles, not {plan.vehicles}.")
    for field in _POSITIVE:
        value = getattr(plan, field)
        if not (math.isfinite(value) and value > 0.0):
            yield PlanProblem(field, f"This must be above 0, but is {value:g}.")
    for field, least in LEAST_FLIGHT_SETTINGS.items():
        value = getattr(plan, field)
        if 0.0 < value < least:
            yield PlanProblem(field, f"This must be {least:g} or more, but is {value:g}.")
    if not math.radians(1.0) < plan.camera_fov_rad < math.radians(170.0):
        yield PlanProblem("camera_fov_rad", "The field of view must lie between 1 and 170 degrees.")
    if not 0.0 <= plan.min_battery_fraction < 0.9:
        yield PlanProblem("min_battery_fraction", "The battery's reserve must lie between 0 and 90 %.")
    if plan.fence_margin_m is not None and not 0.0 <= plan.fence_margin_m < math.inf:
        yield PlanProblem("fence_margin_m", "The distance to the geofence must not be negative.")
    for field, greatest in _GREATEST.items():
        value = getattr(plan, field)
        if value is not None and math.isfinite(value) and value > greatest:
            yield PlanProblem(field, f"This must be {greatest:g} or less, but is {value:g}.")
    yield from _check_heights(plan, settings)
    yield from _check_wanted(plan)
    yield from _check_split(plan, settings)
    if plan.spacing_m is not None and not (math.isfinite(plan.spacing_m) and plan.spacing_m > 0.0):
        yield PlanProblem("spacing_m", f"The spacing of the vehicles must be above 0, but is {plan.spacing_m:g} m.")
        return
    yield from _check_strategy(plan)


def _check_wanted(plan: MissionPlan) -> Iterator[PlanProblem]:
    """Report what the search for a wanted probability of detection cannot be planned with."""
    for field in ("line_spacing_m", "leg_spacing_m"):
        value = getattr(plan, field)
        if value is not None and not value > 0.0:
            yield PlanProblem(field, f"This must be above 0, but is {value:g}.")
    if not 1 <= plan.passes <= MAX_PASSES:
        yield PlanProblem("passes", f"The legs can be flown 1 to {MAX_PASSES} times, but this is {plan.passes}.")
    if plan.pod is not None and not LEAST_POD <= plan.pod <= GREATEST_POD:
        text = f"The wanted probability of detection must lie between {LEAST_POD:.0%} and {GREATEST_POD:.0%}."
        yield PlanProblem("pod", text)


def _check_split(plan: MissionPlan, settings: MissionSettings) -> Iterator[PlanProblem]:
    """Report a split swarm in which no vehicle could ever scan on."""
    search = replace(settings.search, mode=plan.search_mode, split=plan.split)
    fewest, looking = search.fewest_to_split, search.look_vehicles
    if fewest is not None and plan.vehicles < fewest:
        text = (
            f"It takes {fewest} vehicles, {looking} that look closely and {fewest - looking} that scan on: "
            f"with {plan.vehicles}, all look closely."
        )
        yield PlanProblem("split", text, blocking=False)


def _check_strategy(plan: MissionPlan) -> Iterator[PlanProblem]:
    try:
        declared = {parameter.name: parameter for parameter in declared_parameters(plan.strategy)}
    except ConfigurationError as error:
        yield PlanProblem("strategy", str(error))
        return
    refused = list(_refusals(plan.parameters, declared))
    if not refused:
        try:
            make_strategy(plan.strategy, plan.parameters)
        except ParameterError as error:
            refused.append(error)
        except ConfigurationError as error:
            yield PlanProblem("strategy", str(error))
    for refusal in refused:
        is_spacing = refusal.parameter == SPACING_PARAMETER
        yield PlanProblem("spacing_m" if is_spacing else f"strategy_parameters.{refusal.parameter}", str(refusal))


def _refusals(values: Mapping[str, object], declared: Mapping[str, Parameter]) -> Iterator[ParameterError]:
    """Yield the problem of each value on its own."""
    for name, value in values.items():
        if name in declared:
            try:
                declared[name].converted(value)
            except ParameterError as error:
                yield error


def _separation_m(settings: MissionSettings) -> float:
    return settings.safety.applied_to(UNLIMITED).separation_m


def _check_heights(plan: MissionPlan, settings: MissionSettings) -> Iterator[PlanProblem]:
    plane_m = settings.imaging.plane_height_m
    highest_m = plan.highest_layer_m
    separation_m = _separation_m(settings)
    for field in ("floor_m", "ceiling_m"):
        value_m = getattr(plan, field)
        if value_m is not None and not abs(value_m) <= MAX_HEIGHT_M:
            yield PlanProblem(field, f"This must lie within {MAX_HEIGHT_M:g} m of the origin, but is {value_m:g} m.")
    if highest_m > MAX_HEIGHT_M and all(getattr(plan, name) <= most for name, most in GREATEST_FLIGHT_SETTINGS.items()):
        text = (
            f"The highest layer is at {highest_m:g} m, {MAX_HEIGHT_M:g} m are allowed: lower the layers or the spacing."
        )
        yield PlanProblem("layer_spacing_m", text)
    if plan.layer_spacing_m < separation_m:
        yield PlanProblem(
            "layer_spacing_m",
            f"Layers of {plan.layer_spacing_m:g} m are too close: vehicles keep {separation_m:g} m from one another.",
        )
    if plan.lowest_layer_m <= plane_m:
        yield PlanProblem(
            "lowest_layer_m", f"The lowest layer must be above the focal plane, which is at {plane_m:g} m."
        )
    if plan.floor_m is not None and plan.floor_m > plan.lowest_layer_m:
        yield PlanProblem(
            "floor_m", f"The floor of {plan.floor_m:g} m is above the lowest layer of {plan.lowest_layer_m:g} m."
        )
    if plan.ceiling_m is not None and plan.ceiling_m < highest_m:
        yield PlanProblem(
            "ceiling_m",
            f"The ceiling of {plan.ceiling_m:g} m is below the highest of {plan.vehicles} layers, {highest_m:g} m: "
            "raise it, or lower the layers or their spacing.",
        )
    if plan.forest is not None and plan.lowest_layer_m <= plan.forest.canopy_height_m:
        yield PlanProblem(
            "lowest_layer_m",
            f"The lowest layer of {plan.lowest_layer_m:g} m is not above the tree tops, "
            f"{plan.forest.canopy_height_m:g} m.",
        )


def _check_limits(plan: MissionPlan, settings: MissionSettings) -> Iterator[PlanProblem]:
    """Report what the limits in flight refuse, beyond the checks above."""
    try:
        apply_plan(settings, plan)
    except ConfigurationError as error:
        yield PlanProblem("fence_margin_m", str(error))
    try:
        forest_aperture(plan, settings.imaging.plane_height_m)
    except ConfigurationError as error:
        yield PlanProblem("forest", str(error))


def _check_legs(plan: MissionPlan, settings: MissionSettings) -> Iterator[PlanProblem]:
    count = plan.passes * planned_leg_count(plan, settings.imaging.plane_height_m)
    if count > MAX_LEGS:
        text = f"The search area takes {count} legs, {MAX_LEGS} are allowed: make it smaller, or widen the spacing."
        yield PlanProblem("area_enu_m", text)
    elif plan.forest is not None and _exposures(plan, settings.imaging.plane_height_m, count) > MOST_EXPOSURES:
        text = (
            f"Frames of {plan.vehicles} vehicles are {plan.leg_speed_mps / plan.rate_hz:g} m apart along the legs: too "
            "many to predict the probability of detection. Search faster, with fewer vehicles or frames per second, or "
            "without describing the forest."
        )
        yield PlanProblem("search_speed_mps", text)


def _exposures(plan: MissionPlan, plane_height_m: float, legs: int) -> float:
    """Return about how many exposures the estimate of a plan counts."""
    counted = exposures_of_a_pass(plan, plane_height_m)
    if plan.search_mode is SearchMode.CONTINUOUS:
        counted += exposures_of_places(plan, plane_height_m, legs)
    return counted
