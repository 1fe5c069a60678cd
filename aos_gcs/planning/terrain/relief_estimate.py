"""Estimates of plans over relief: the swath is narrower above high ground, and climbs begin and end on the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.aperture import footprint_m
from aos_gcs.planning.checks.sites import Homes
from aos_gcs.planning.detection.expected_views import predicted_detection
from aos_gcs.planning.estimate import CLIMB_MPS, SINK_MPS, PlanEstimate, estimate_plan, launch_place
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.terrain.check import PlannedRelief, planned_relief
from aos_gcs.planning.terrain.profile import LegProfile, profiles_over
from aos_gcs.planning.terrain.viewed_ground import viewed_ground
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

_LEAST_HEIGHT_M = 1.0
"""Height above the ground that footprints are computed for at least."""


def estimate_over_ground(
    plan: MissionPlan,
    settings: MissionSettings,
    origin: GeodeticPosition | None,
    homes_enu_m: Homes,
    legs: Sequence[ScanLeg] = (),
) -> PlanEstimate:
    """Estimate a plan over the ground of the mission's elevation model, or over level ground where there is none.

    Args:
        plan: to be flown, without a blocking problem.
        settings: settings of the mission that is to fly it.
        origin: origin of the plan, where the settings have none.
        homes_enu_m: launch points of the vehicles that are heard already.
        legs: legs of the plan in the order in which they are flown; none: to and fro.

    Raises:
        ConfigurationError: the plan cannot be flown.
    """
    plane_height_m = settings.imaging.plane_height_m
    level = estimate_plan(plan, plane_height_m, legs)
    terrain, origin = settings.terrain, settings.origin or origin
    if terrain is None or origin is None:
        return level
    try:
        relief = planned_relief(plan, terrain, origin, homes_enu_m, level.legs, is_reported=settings.origin is None)
    except (ConfigurationError, InputDataError):
        return level  # the check of the plan names what is wrong with the elevation model
    # Of a surface model, or with a level focal plane, the map of searched ground shows no ground either.
    ground = relief.ground if settings.focus_follows_ground else None
    viewed = viewed_ground(plan.area_enu_m, ground, relief.band.surface)
    profiles = profiles_over(plan, level.legs, relief)
    up_m, down_m = _climbs_m(plan, relief)
    rises_m = sum(float(np.maximum(np.diff(profile.surface_m), 0.0).sum()) for profile in profiles)
    later_s = (up_m - plan.highest_layer_m) / CLIMB_MPS + (down_m - plan.highest_layer_m) / SINK_MPS
    flight_s = level.flight_s + later_s
    return replace(
        level,
        covered_fraction=_covered_fraction(plan, level, profiles, plane_height_m),
        climb_m=up_m + rises_m,
        flight_s=flight_s,
        battery_fraction=flight_s / plan.endurance_s,
        detection=predicted_detection(plan, level.legs, plane_height_m, ground=viewed),
        viewed=viewed,
    )


def _climbs_m(plan: MissionPlan, relief: PlannedRelief) -> tuple[float, float]:
    """Return how far the highest vehicle climbs at the launch point, and descends where it lands."""
    launch_m = launch_place(plan)
    places_m = np.array([launch_m, launch_m if plan.return_enu_m is None else plan.return_enu_m])
    ground_m = np.nan_to_num(relief.ground.heights_at(places_m))
    up_m, down_m = plan.highest_layer_m + relief.band.surface.height_m(places_m) - ground_m
    return float(up_m), float(down_m)


def _covered_fraction(
    plan: MissionPlan, level: PlanEstimate, profiles: Sequence[LegProfile], plane_height_m: float
) -> float:
    raster = PlanRaster.around(plan.area_enu_m)
    inside, barred = raster.inside([plan.area_enu_m]), raster.inside(plan.no_go_enu_m)
    widest_m = footprint_m(plan.lowest_layer_m - plane_height_m, plan.camera_fov_rad)
    pieces: list[Polygon] = []
    for leg, profile in zip(level.legs, profiles, strict=True):
        above_m = plan.lowest_layer_m + profile.surface_m - profile.highest_ground_m - plane_height_m
        views_m = [
            footprint_m(max(_LEAST_HEIGHT_M, height_m), plan.camera_fov_rad) if np.isfinite(height_m) else widest_m
            for height_m in above_m.tolist()
        ]
        swaths_m = np.array(views_m) + level.swath_m - widest_m
        pieces += _pieces(leg, profile.distances_m, swaths_m)
    return raster.area_m2(inside & raster.inside(pieces) & ~barred) / raster.area_m2(inside)


def _pieces(leg: ScanLeg, distances_m: FloatArray, swaths_m: FloatArray) -> list[Polygon]:
    """Return the rectangles that a leg sees, each as wide as the swath at its place."""
    start_m, direction = np.array(leg.start_enu_m), np.array(leg.direction_enu)
    across = line_axis(direction)
    between_m = np.concatenate(([0.0], (distances_m[1:] + distances_m[:-1]) / 2.0, [leg.length_m]))
    pieces = []
    for index, swath_m in enumerate(swaths_m.tolist()):
        ends_m = [start_m + between_m[index + end] * direction for end in (0, 1)]
        corners_m = [
            *(ends_m[0] + side * swath_m / 2.0 * across for side in (1.0, -1.0)),
            *(ends_m[1] + side * swath_m / 2.0 * across for side in (-1.0, 1.0)),
        ]
        pieces.append(tuple((float(corner_m[0]), float(corner_m[1])) for corner_m in corners_m))
    return pieces
