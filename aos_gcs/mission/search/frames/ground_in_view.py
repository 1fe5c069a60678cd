"""The ground that a step's frames show, for the places of what is seen on it."""

from __future__ import annotations

import numpy as np

from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.imaging.model import FocalGrid
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.planning.settings import MissionSettings

_SPACING_M = 2.0
_MAX_SAMPLES = 200
"""Largest number of samples along each axis."""


def ground_in_view(settings: MissionSettings, ground: GroundRaster | None, grid: FocalGrid) -> Terrain | None:
    """Return the ground below a step's raster; None where the focal plane does not follow it, or none is known.

    Args:
        settings: settings of the mission.
        ground: ground of the mission's elevation model, as the vehicles see it.
        grid: raster of the step's analysis.
    """
    if ground is None or not settings.focus_follows_ground:
        return None
    width_m, depth_m = grid.columns * grid.resolution_m, grid.rows * grid.resolution_m
    spacing_m = max(_SPACING_M, max(width_m, depth_m) / _MAX_SAMPLES)
    east_m = grid.west_m + spacing_m * np.arange(int(width_m / spacing_m) + 2)
    north_m = grid.north_m - depth_m + spacing_m * np.arange(int(depth_m / spacing_m) + 2)
    places_m = np.stack(np.meshgrid(east_m, north_m), axis=-1)
    heights_m = ground.heights_at(places_m.reshape(-1, 2)).reshape(places_m.shape[:2])
    if not np.isfinite(heights_m).any():
        return None
    return Terrain(float(east_m[0]), float(north_m[0]), spacing_m, heights_m)
