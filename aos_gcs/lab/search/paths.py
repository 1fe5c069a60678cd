"""Exposures of the flights that are compared: when and where each camera takes its frames.

Cameras look straight down with their upper edge to the north, and legs run north and south, or east and west. Speeds,
stops and climbs are those of the estimates of plans (:mod:`aos_gcs.planning.estimate`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.aperture import footprint_m
from aos_gcs.lab.search.model import Method
from aos_gcs.planning.detection.expected_views import LineOfCameras, line_of
from aos_gcs.planning.detection.pod_proposal import propose_pattern
from aos_gcs.planning.estimate import (
    ACCELERATION_MPS2,
    CLIMB_MPS,
    SINK_MPS,
    STILL_S,
    move_s,
    planned_legs,
    scan_step_m,
)
from aos_gcs.planning.leg_order import chances_of, order_legs
from aos_gcs.planning.legs import ScanLeg, in_passes
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.prior.model import AreaPrior
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

LAWNMOWER_OVERLAP: Final = 0.3
"""Share of a footprint that neighbouring strips of the lawnmower have in common."""
LAWNMOWER_MPS: Final = 5.0
SINGLE_MPS: Final = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class SearchFlight:
    """One flight over an area, from take-off to landing, and its exposures."""

    times_s: FloatArray
    """Times from the take-off, ascending, shape (k,)."""
    cameras_enu_m: FloatArray
    """Shape (k, 3)."""
    duration_s: float
    path_m: float
    """Length of the ways of all vehicles together, climbs left out."""


def flown_plan(plan: MissionPlan, method: Method) -> MissionPlan | None:
    """Return the plan of a method that flies along legs; None where no plan reaches what is wanted."""
    if method is Method.TWICE:
        plan = replace(plan, passes=2)
    if method in {Method.PLANNED, Method.PRIOR, Method.TWICE}:
        pattern = propose_pattern(plan, 0.0)
        return None if pattern is None else pattern.applied_to(plan)
    # Their lines are those of missions without a wanted probability of detection.
    plan = replace(plan, pod=None)
    if method is Method.STOPS:
        return replace(plan, search_mode=SearchMode.STOPS)
    if method is Method.SINGLE:
        return replace(plan, vehicles=1, search_speed_mps=SINGLE_MPS)
    if method is Method.LAWNMOWER:
        strip_m = (1.0 - LAWNMOWER_OVERLAP) * footprint_m(plan.lowest_layer_m, plan.camera_fov_rad)
        return replace(
            plan, line_spacing_m=strip_m, leg_spacing_m=plan.vehicles * strip_m, search_speed_mps=LAWNMOWER_MPS
        )
    return plan


def fly_legs(plan: MissionPlan, number: int = 0, prior: AreaPrior | None = None) -> SearchFlight:
    """Return the flight of a plan along its legs.

    Args:
        plan: to be flown; it has a launch point.
        number: number of the flight: later ones cross the first, or have their legs and exposures between its.
        prior: where the person is likely to be, by which the legs are ordered; None: they are flown to and fro.
    """
    plan = replace(plan, scan_heading_rad=math.pi / 2.0 * (number % 2))
    shift = math.modf(number // 2 * (math.sqrt(5.0) - 1.0) / 2.0)[0]
    legs, line = planned_legs(plan, 0.0), line_of(plan, 0.0)
    if plan.search_mode is SearchMode.STOPS:
        step_m = scan_step_m(plan)
        line = replace(line, interval_m=step_m)
        mps, still_s = step_m / (move_s(step_m, plan.cruise_speed_mps) + STILL_S), 0.0
    else:
        mps = plan.leg_speed_mps
        still_s = STILL_S + mps / (2.0 * ACCELERATION_MPS2)
    launch_m = plan.launch_enu_m or (0.0, 0.0)
    if prior is not None:
        legs = order_legs(legs, plan, chances_of(plan, 0.0, prior), launch_m)
    else:
        legs = in_passes(legs, plan.passes)
    between_m = [math.dist(one.end_enu_m, after.start_enu_m) for one, after in pairwise(legs)]
    ways_m = [math.dist(launch_m, legs[0].start_enu_m), *between_m]
    now_s, times_s, cameras_m = plan.highest_layer_m / CLIMB_MPS, [], []
    for leg, way_m in zip(legs, ways_m, strict=True):
        now_s += move_s(way_m, plan.cruise_speed_mps)
        along_m, own_m = _exposures(leg, line, shift)
        times_s.append(now_s + still_s + along_m / mps)
        cameras_m.append(own_m)
        now_s += leg.length_m / mps + 2.0 * still_s - (STILL_S if still_s else 0.0)
    home_m = math.dist(legs[-1].end_enu_m, launch_m)
    now_s += move_s(home_m, plan.cruise_speed_mps) + plan.highest_layer_m / SINK_MPS
    path_m = (sum(leg.length_m for leg in legs) + sum(ways_m) + home_m) * plan.vehicles
    return ordered(np.concatenate(times_s), np.concatenate(cameras_m), now_s, path_m)


def ordered(times_s: FloatArray, cameras_enu_m: FloatArray, duration_s: float, path_m: float) -> SearchFlight:
    """Return a flight with its exposures in the order of their times."""
    order = np.argsort(times_s, kind="stable")
    return SearchFlight(times_s[order], cameras_enu_m[order], duration_s, path_m)


def _exposures(leg: ScanLeg, line: LineOfCameras, shift: float) -> tuple[FloatArray, FloatArray]:
    """Return the distances along a leg of all exposures, shape (k,), and the cameras' places, shape (k, 3).

    Args:
        leg: the leg.
        line: the swarm's line.
        shift: share of an interval by which all exposures, and of a spacing by which all vehicles are displaced.
    """
    along, start_m = np.array(leg.direction_enu), np.array(leg.start_enu_m)
    spacing_m = float(line.aside_m[1] - line.aside_m[0]) if len(line.aside_m) > 1 else 0.0
    along_m = np.arange(shift * line.interval_m, leg.length_m + 1e-6, line.interval_m)
    aside_m, heights_m = line.aside_m + shift * spacing_m / 2.0, line.heights_on_m(leg)
    places_m = (
        start_m + along_m[:, np.newaxis, np.newaxis] * along + aside_m[np.newaxis, :, np.newaxis] * line_axis(along)
    )
    cameras_m = np.concatenate((places_m, np.broadcast_to(heights_m[:, np.newaxis], (*places_m.shape[:2], 1))), axis=2)
    return np.repeat(along_m, len(aside_m)), np.asarray(cameras_m.reshape(-1, 3), dtype=np.float64)
