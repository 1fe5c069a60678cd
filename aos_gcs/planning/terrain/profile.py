"""Profile of a plan: the ground below each leg, and the heights above it that vehicles fly and keep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.planning.checks.sites import Homes
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.proposal import proposed_ceiling_m, proposed_floor_m
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.terrain.check import PlannedRelief, planned_relief, swept_m

FloatArray = NDArray[np.float64]

MAX_SAMPLES = 2000
"""Greatest number of samples of all legs together, as far as each keeps a few."""
_FEWEST, _MOST = 9, 61
"""Samples of one leg."""
_INTERVAL_M = 4.0
"""Distance of samples of a short leg: two cells of the ground's raster."""


@dataclass(frozen=True, slots=True)
class LegProfile:
    """Heights above the origin along one leg; arrays of shape (n,), metres. NaN where the ground is not known."""

    distances_m: FloatArray
    """Distances from the start of the leg, ascending."""
    lowest_ground_m: FloatArray
    """Lowest ground below the whole line of the swarm."""
    highest_ground_m: FloatArray
    surface_m: FloatArray
    """Surface that the altitude layers are offset from: 0 where they are level."""
    floor_m: FloatArray
    """Floor above the ground, or above the origin where the ground counts as level."""
    ceiling_m: FloatArray


def plan_profile(
    plan: MissionPlan,
    settings: MissionSettings,
    origin: GeodeticPosition | None,
    homes_enu_m: Homes,
    legs: Sequence[ScanLeg],
) -> tuple[LegProfile, ...]:
    """Return the profile of each leg; none where the elevation model's ground is asked for at no known origin.

    Args:
        plan: plan with valid shapes and numbers.
        settings: settings of the mission that is to fly it.
        origin: origin of the plan, where the settings have none.
        homes_enu_m: launch points of the vehicles that are heard already.
        legs: legs of the plan.

    Raises:
        ConfigurationError: the elevation model cannot be used, or a library is missing.
        InputDataError: a file of it cannot be used or read.
    """
    terrain, origin = settings.terrain, settings.origin or origin
    if terrain is not None and origin is None:
        return ()
    if terrain is None or origin is None:
        return tuple(_level(plan, leg) for leg in legs)
    is_reported = settings.origin is None
    relief = planned_relief(plan, terrain, origin, homes_enu_m, legs, is_reported=is_reported)
    return profiles_over(plan, legs, relief)


def profiles_over(plan: MissionPlan, legs: Sequence[ScanLeg], relief: PlannedRelief) -> tuple[LegProfile, ...]:
    """Return the profile of each leg over known ground."""
    count = max(_FEWEST, min(_MOST, MAX_SAMPLES // max(1, len(legs))))
    return tuple(_above_ground(plan, leg, relief, count) for leg in legs)


def _level(plan: MissionPlan, leg: ScanLeg) -> LegProfile:
    """Return the profile over ground that counts as level."""
    floor_m = proposed_floor_m(plan.lowest_layer_m) if plan.floor_m is None else plan.floor_m
    ceiling_m = proposed_ceiling_m(plan.highest_layer_m) if plan.ceiling_m is None else plan.ceiling_m
    ground_m = np.zeros(2)
    return LegProfile(
        distances_m=np.array([0.0, leg.length_m]),
        lowest_ground_m=ground_m,
        highest_ground_m=ground_m,
        surface_m=ground_m,
        floor_m=ground_m + floor_m,
        ceiling_m=ground_m + ceiling_m,
    )


def _above_ground(plan: MissionPlan, leg: ScanLeg, relief: PlannedRelief, most: int) -> LegProfile:
    count = max(2, min(most, int(leg.length_m / _INTERVAL_M) + 1))
    distances_m = np.linspace(0.0, leg.length_m, count)
    places_m = np.array(leg.start_enu_m) + distances_m[:, None] * np.array(leg.direction_enu)
    lowest_m, highest_m = _bounds_across(plan, leg, relief.ground, distances_m, places_m)
    return LegProfile(
        distances_m=distances_m,
        lowest_ground_m=lowest_m,
        highest_ground_m=highest_m,
        surface_m=relief.band.surface.height_m(places_m),
        floor_m=highest_m + relief.band.floor_m,
        ceiling_m=lowest_m + relief.band.ceiling_m,
    )


def _bounds_across(
    plan: MissionPlan, leg: ScanLeg, ground: GroundRaster, distances_m: FloatArray, places_enu_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest ground below the swarm's line about each place of a leg, shape (n,) each."""
    cells = ground.within([swept_m(plan, leg)])
    along_m = (cells.places_enu_m - np.array(leg.start_enu_m)) @ np.array(leg.direction_enu)
    step_m = distances_m[1] - distances_m[0]
    nearest = np.rint(along_m / step_m).astype(np.int64).clip(0, len(distances_m) - 1)
    # A place without a cell of its own, where the raster is coarse, has the ground of the cell that it lies in.
    lowest_m, highest_m = ground.bounds_at(places_enu_m)
    with np.errstate(invalid="ignore"):  # ground that is not known makes the height there unknown
        np.minimum.at(lowest_m, nearest, cells.lowest_m)
        np.maximum.at(highest_m, nearest, cells.highest_m)
    return lowest_m, highest_m
