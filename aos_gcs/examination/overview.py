"""Map of all frames of a recorded flight, which grows while they are examined."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.integral import ViewIntegral
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.pictures import encode_png, shade_integral, shade_thermal
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.imaging.views import grid_view
from aos_gcs.mission.model.steps import Picture, PictureKind
from aos_gcs.surveys.tiles import Placed

MAX_CELLS = 1_000_000
"""Largest map."""
MAX_EXTENT_M = 100_000.0
"""Longest edge of the ground that a map shows."""
_COARSE_M = 5.0


class Overview:
    """Mean of the frames on the plane of the ground.

    Args:
        views: cameras and poses of all frames to come, in an east-north-up world.
        bands: bands of all frames.
        ground_m: height of the plane.
    """

    def __init__(self, views: Sequence[Placed], bands: tuple[str, ...], ground_m: float) -> None:
        self.grid = overview_grid(views, ground_m)
        self._bands = bands
        self._integral = ViewIntegral(grid_view(self.grid), bands, exact=False)

    def add(self, frames: Sequence[Frame]) -> None:
        """Add frames."""
        if frames:
            self._integral.add_all(frames)

    def pictures(self, step: int) -> tuple[Picture, ...]:
        """Return the map as it is, in colour or grey, and where there is such a band in temperatures."""
        grid, mean = self.grid, self._integral.mean()
        images = {PictureKind.INTEGRAL: shade_integral(mean, self._bands)}
        if "thermal" in self._bands:
            images[PictureKind.THERMAL] = shade_thermal(mean[:, :, self._bands.index("thermal")])
        return tuple(
            Picture(
                kind,
                step,
                encode_png(image),
                west_m=grid.west_m,
                south_m=grid.north_m - grid.rows * grid.resolution_m,
                east_m=grid.west_m + grid.columns * grid.resolution_m,
                north_m=grid.north_m,
            )
            for kind, image in images.items()
        )


def overview_grid(views: Sequence[Placed], ground_m: float) -> FocalGrid:
    """Return a raster of at most :data:`MAX_CELLS` that holds all that the cameras see.

    Raises:
        ImagingError: if none sees the ground, or all of them too much of it.
    """
    cameras = [(view.camera, view.pose) for view in views]
    outlines_m = [footprint(camera, pose, ground_m) for camera, pose in cameras]
    seen_m = np.concatenate([outline_m for outline_m in outlines_m if len(outline_m)] or [np.zeros((1, 2))])
    extent_m = float(np.ptp(seen_m, axis=0).max())
    if not extent_m <= MAX_EXTENT_M:
        raise ImagingError(
            f"The pictures see ground over {extent_m / 1000.0:.4g} km, more than {MAX_EXTENT_M / 1000.0:g} km: check "
            "the height of the ground and the field of view, and put each flight into a folder of its own, or choose "
            "its pictures with --frames."
        )
    coarse = choose_raster(cameras, Plane(ground_m), _COARSE_M)
    resolution_m = max(0.05, _COARSE_M * math.sqrt(coarse.rows * coarse.columns / MAX_CELLS))
    raster = choose_raster(cameras, Plane(ground_m), resolution_m)
    return FocalGrid(raster.x_m, raster.y_m, resolution_m, raster.rows, raster.columns, ground_m)
