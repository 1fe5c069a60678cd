"""Map raster of the ground that frames see, in metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface

MAX_CELLS = 1_000_000_000
"""Largest number of cells of a map: 4 GB per band on the disk."""


def choose_raster(cameras: Sequence[tuple[CameraModel, Pose]], surface: FocalSurface, resolution_m: float) -> MapRaster:
    """Return a map that holds all that cameras see of a surface, as it looks from their side.

    Its edges lie at multiples of the resolution. On terrain it may be larger than needed, see :func:`covered_part`.

    Raises:
        ImagingError: if no camera sees the surface, or the map would have more than ``MAX_CELLS``.
    """
    if isinstance(surface, Terrain):
        planes = [Plane(float(surface.lower_m[2])), Plane(float(surface.upper_m[2]))]
    else:
        planes = [surface]
    outlines = [footprint(camera, pose, plane) for camera, pose in cameras for plane in planes]
    points = np.concatenate(outlines) if outlines else np.empty((0, 2))
    if not len(points):
        raise ImagingError(
            "No image has the focal surface in front of its camera: check its height, and that it is given in the "
            "world of the poses."
        )
    lower, upper = points.min(axis=0), points.max(axis=0)
    if isinstance(surface, Terrain):
        lower, upper = np.maximum(lower, surface.lower_m[:2]), np.minimum(upper, surface.upper_m[:2])
        if (lower >= upper).any():
            raise ImagingError(
                "No image sees the terrain: check that it lies below the flight, in the world of the poses."
            )
    first, last = np.floor(lower / resolution_m), np.ceil(upper / resolution_m)
    columns, rows = (int(size) for size in last - first)
    if rows * columns > MAX_CELLS:
        raise ImagingError(
            f"A map of {(upper - lower)[0]:.6g} m x {(upper - lower)[1]:.6g} m at {resolution_m:g} m has {rows:.6g} x "
            f"{columns:.6g} cells, more than {MAX_CELLS}: choose a coarser resolution."
        )
    # Cameras that look along +z see rows along +y unmirrored.
    along_y = math.fsum(pose.R_cam2enu[2, 2] for _, pose in cameras) > 0.0
    y_m = float(first[1] if along_y else last[1]) * resolution_m
    return MapRaster(float(first[0]) * resolution_m, y_m, resolution_m, rows, columns, along_y)


def covered_part(raster: MapRaster, coverage: NDArray[np.uint16]) -> tuple[MapRaster, tuple[slice, slice]]:
    """Return the smallest map with all covered cells, and the window it takes up.

    Raises:
        ImagingError: if nothing is covered.
    """
    rows, columns = np.flatnonzero(coverage.any(axis=1)), np.flatnonzero(coverage.any(axis=0))
    if not rows.size:
        raise ImagingError("No image covers any cell of the map: check the focal surface and the poses.")
    window = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    return raster_part(raster, window), window


def raster_part(raster: MapRaster, window: tuple[slice, slice]) -> MapRaster:
    """Return the map of a window's rows and columns."""
    rows, columns = window
    step_m = raster.resolution_m if raster.rows_along_y else -raster.resolution_m
    return replace(
        raster,
        x_m=raster.x_m + columns.start * raster.resolution_m,
        y_m=raster.y_m + rows.start * step_m,
        rows=rows.stop - rows.start,
        columns=columns.stop - columns.start,
    )
