"""The reference surface of a mission's altitude layers, where they follow the ground."""

from __future__ import annotations

import numpy as np

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface, reference_surface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.planning.settings import TerrainSettings

CLIMB_MPS = 1.0
"""Vertical speed that ArduCopter and PX4 keep by their defaults, upwards and downwards, with a reserve."""


def layer_surface(
    terrain: TerrainSettings | None, ground: GroundRaster | None, limits: SafetyLimits, cruise_speed_mps: float
) -> ReferenceSurface:
    """Return the surface that all altitude layers of a flight are offset from; level unless they follow the ground.

    It depends on nothing else, so that a flight that is taken up, or a decision that is made again, has the same.

    Args:
        terrain: elevation model, and whether layers follow it.
        ground: ground as the vehicles see it, of the whole geofence; None: it counts as level.
        limits: limits of the flight.
        cruise_speed_mps: speed along the surface.
    """
    if terrain is None or not terrain.follow or ground is None:
        return LEVEL
    return followed_surface(ground, limits, cruise_speed_mps)


def followed_surface(ground: GroundRaster, limits: SafetyLimits, cruise_speed_mps: float) -> ReferenceSurface:
    """Return the surface above the ground that layers are offset from, as far as vehicles are sent."""
    fence_m = np.array(limits.fence_enu_m)
    low_m, high_m = fence_m.min(axis=0), fence_m.max(axis=0)
    # No waypoint lies in the margin: hills there do not count.
    margin_m = np.minimum(limits.margin_m, (high_m - low_m) / 4.0)
    (west_m, south_m), (east_m, north_m) = (low_m + margin_m).tolist(), (high_m - margin_m).tolist()
    return reference_surface(ground, (west_m, south_m, east_m, north_m), max_slope(cruise_speed_mps))


def max_slope(cruise_speed_mps: float) -> float:
    """Return the greatest slope of a surface along which vehicles fly at a speed."""
    return CLIMB_MPS / cruise_speed_mps
