"""Estimates of a plan: legs, time, coverage, battery.

The figures are estimates of a search that finds nothing, and therefore flies all legs to their ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.groundmap.figures import DetectionFigures
from aos_gcs.imaging.aperture import footprint_m
from aos_gcs.planning.detection.expected_views import predicted_detection
from aos_gcs.planning.legs import ScanLeg, in_passes, leg_count, scan_legs
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.swarm.line import line_axis, line_places
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.registry import strategy_for

ACCELERATION_MPS2 = 2.5
"""Acceleration of multirotors that fly from waypoint to waypoint."""
STILL_S = 1.2
"""Time per step to settle, expose, transfer and decide."""
_M2_PER_HECTARE = 1e4
_S_PER_HOUR = 3600.0
CLIMB_MPS = 2.5
SINK_MPS = 1.0


@dataclass(frozen=True, slots=True)
class FlightEstimate:
    """Figures of a flight along some legs to their ends."""

    path_m: float
    """Length of the path of the swarm's middle, from the launch site and back."""
    scan_s: float
    duration_s: float
    """Time from the first take-off to the last landing."""


@dataclass(frozen=True, slots=True)
class PlanEstimate:
    """Figures of a plan in which nothing is found."""

    legs: tuple[ScanLeg, ...]
    swath_m: float
    """Width that the swarm's line sees."""
    area_m2: float
    free_area_m2: float
    """Search area without the no-go zones."""
    covered_fraction: float
    """Share of the whole area that the legs sweep."""
    path_m: float
    """Length of the path of the swarm's middle, from the launch site and back."""
    scan_s: float
    flight_s: float
    """Time from the first take-off to the last landing."""
    battery_fraction: float
    """Share of a full battery that the flight takes."""
    climb_m: float
    """Climbs of the highest vehicle, added up."""
    detection: DetectionFigures | None
    """Mean probability of detection over the search area; None where the forest is not described, or views are not
    predicted, because the swarm stops for each frame."""
    viewed: ViewedGround = field(default=LEVEL_GROUND, compare=False, repr=False)
    """Ground on which the views were predicted."""

    @property
    def hectares_per_hour(self) -> float:
        """Part of the search area that is swept per time of the flight, from the first take-off to the last landing."""
        return self.covered_fraction * self.area_m2 / _M2_PER_HECTARE / (self.flight_s / _S_PER_HOUR)


def estimate_plan(plan: MissionPlan, plane_height_m: float, legs: Sequence[ScanLeg] = ()) -> PlanEstimate:
    """Estimate a plan over level ground that :func:`aos_gcs.planning.checks.check.check_plan` finds nothing wrong with.

    Args:
        plan: to be flown.
        plane_height_m: height of the focal plane above the origin.
        legs: legs of all its passes in the order in which they are flown; none: to and fro.

    Raises:
        ConfigurationError: the plan cannot be flown.
    """
    raster = PlanRaster.around(plan.area_enu_m)
    inside, barred = raster.inside([plan.area_enu_m]), raster.inside(plan.no_go_enu_m)
    legs = tuple(legs) or in_passes(planned_legs(plan, plane_height_m), plan.passes)
    swath_m = _swath_m(plan, plane_height_m)
    swept = raster.inside([_swept(leg, swath_m) for leg in legs])
    (flight,) = estimate_flights(plan, [legs])
    return PlanEstimate(
        legs=legs,
        swath_m=swath_m,
        area_m2=raster.area_m2(inside),
        free_area_m2=raster.area_m2(inside & ~barred),
        covered_fraction=raster.area_m2(inside & swept & ~barred) / raster.area_m2(inside),
        path_m=flight.path_m,
        scan_s=flight.scan_s,
        flight_s=flight.duration_s,
        battery_fraction=flight.duration_s / plan.endurance_s,
        climb_m=plan.highest_layer_m,
        detection=predicted_detection(plan, legs, plane_height_m),
    )


def planned_legs(plan: MissionPlan, plane_height_m: float, heading_rad: float | None = None) -> tuple[ScanLeg, ...]:
    """Return the legs of one pass of a plan, or those of another heading."""
    return scan_legs(
        plan.area_enu_m,
        np.array(launch_place(plan)),
        _direction(plan.scan_heading_rad if heading_rad is None else heading_rad),
        n=plan.vehicles,
        spacing_m=plan.on_legs_m,
        footprint_m=footprint_m(plan.lowest_layer_m - plane_height_m, plan.camera_fov_rad),
        leg_spacing_m=plan.leg_spacing_m,
    )


def planned_leg_count(plan: MissionPlan, plane_height_m: float, heading_rad: float | None = None) -> int:
    """Return how many legs a pass of a plan has, or those of another heading; cheap, however many they are."""
    direction_enu = _direction(plan.scan_heading_rad if heading_rad is None else heading_rad)
    swath_m = _swath_m(plan, plane_height_m)
    widest_m = swath_m if plan.leg_spacing_m is None else min(swath_m, plan.leg_spacing_m)
    return leg_count(plan.area_enu_m, direction_enu, widest_m)


def estimate_flights(plan: MissionPlan, patterns: Sequence[Sequence[ScanLeg]]) -> list[FlightEstimate]:
    """Estimate flights of a plan along the legs of one or another heading."""
    if plan.search_mode is SearchMode.CONTINUOUS:
        return [_estimate_flight(plan, legs, _sweeps_s(plan, legs)) for legs in patterns]
    step_m = scan_step_m(plan)
    scan_mps = step_m / (move_s(step_m, plan.cruise_speed_mps) + STILL_S)
    return [_estimate_flight(plan, legs, sum(leg.length_m for leg in legs) / scan_mps) for legs in patterns]


def _sweeps_s(plan: MissionPlan, legs: Sequence[ScanLeg]) -> float:
    """Return the time on legs that are flown without stops: each begins with a step at rest, as it ends."""
    return sum(move_s(leg.length_m, plan.leg_speed_mps) + STILL_S for leg in legs)


def _estimate_flight(plan: MissionPlan, legs: Sequence[ScanLeg], scan_s: float) -> FlightEstimate:
    start_enu_m = launch_place(plan)
    landing_enu_m = start_enu_m if plan.return_enu_m is None else plan.return_enu_m
    transfers_m = _transfers_m(legs, start_enu_m, landing_enu_m)
    scanned_m = sum(leg.length_m for leg in legs)
    transfer_s = sum(move_s(length_m, plan.cruise_speed_mps) for length_m in transfers_m)
    highest_m = plan.highest_layer_m
    duration_s = scan_s + transfer_s + highest_m / CLIMB_MPS + highest_m / SINK_MPS
    return FlightEstimate(scanned_m + sum(transfers_m), scan_s, duration_s)


def launch_place(plan: MissionPlan) -> tuple[float, float]:
    """Return the launch point, or the origin where a plan has none."""
    return (0.0, 0.0) if plan.launch_enu_m is None else plan.launch_enu_m


def scan_step_m(plan: MissionPlan) -> float:
    """Return how far the strategy moves its line per step while nothing is in view, by asking it."""
    strategy = strategy_for(plan.vehicles, plan.strategy, plan.parameters)
    north = np.array([0.0, 1.0])
    places_m = line_places(np.zeros(2), north, plan.vehicles, strategy.spacing_m)
    nothing = Observation(
        vehicle_ids=tuple(range(1, plan.vehicles + 1)),
        positions_enu_m=places_m,
        fitness=np.zeros(plan.vehicles),
        target_in_view=False,
    )
    state = strategy.tell(strategy.init(north), nothing)
    following_m, _ = strategy.ask(state, np.random.default_rng(0))
    return max(0.1, float((following_m - places_m)[:, 1].mean()))


def move_s(distance_m: float, speed_mps: float) -> float:
    """Return the duration of a move from rest to rest."""
    ramp_m = speed_mps**2 / ACCELERATION_MPS2
    if distance_m < ramp_m:
        return 2.0 * math.sqrt(distance_m / ACCELERATION_MPS2)
    return distance_m / speed_mps + speed_mps / ACCELERATION_MPS2


def _direction(heading_rad: float) -> NDArray[np.float64]:
    return np.array([math.sin(heading_rad), math.cos(heading_rad)])


def _swath_m(plan: MissionPlan, plane_height_m: float) -> float:
    return (plan.vehicles - 1) * plan.on_legs_m + footprint_m(plan.lowest_layer_m - plane_height_m, plan.camera_fov_rad)


def _transfers_m(
    legs: Sequence[ScanLeg], start_enu_m: tuple[float, float], end_enu_m: tuple[float, float]
) -> list[float]:
    """Return the lengths of the flights to the legs, between them, and home."""
    if not legs:
        return []
    between_m = [math.dist(leg.end_enu_m, following.start_enu_m) for leg, following in pairwise(legs)]
    return [math.dist(start_enu_m, legs[0].start_enu_m), *between_m, math.dist(legs[-1].end_enu_m, end_enu_m)]


def _swept(leg: ScanLeg, swath_m: float) -> Polygon:
    """Return the rectangle that a leg sees."""
    start_m, end_m, direction = np.array(leg.start_enu_m), np.array(leg.end_enu_m), np.array(leg.direction_enu)
    aside_m: NDArray[np.float64] = line_axis(direction) * swath_m / 2.0
    corners_m = (start_m + aside_m, start_m - aside_m, end_m - aside_m, end_m + aside_m)
    return tuple((float(corner[0]), float(corner[1])) for corner in corners_m)
