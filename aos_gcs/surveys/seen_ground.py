"""Ground that frames of a recording see, and whether its height is known.

It is counted in cells of a level raster at the height of the ground, which has no end: frames that lie far apart take
no more memory than near ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.tiles import Placed

_COARSE_M = 2.0
"""Smallest cells."""
_MAX_EDGE_CELLS = 500
"""Largest number of cells along the view of a frame; they are larger where frames see far."""
_ROW_CELLS = 1 << 31
"""Number of cells from one row to the next."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenGround:
    """Ground that frames see."""

    cells: tuple[NDArray[np.int64], ...]
    """Numbers of the cells in the view of each frame that have a height."""
    known: int
    """Number of different cells among them."""
    total: int
    """Number of different cells that the frames see, those without a height included."""

    @property
    def share_unknown(self) -> float:
        """Share of the ground that has no height."""
        return 1.0 - self.known / self.total if self.total else 0.0


def seen_ground(views: Sequence[Placed], surface: FocalSurface, ground_m: float) -> SeenGround:
    """Return the ground that frames see.

    Args:
        views: cameras and poses of the frames.
        surface: ground, in the world of their poses.
        ground_m: height at which its cells lie.
    """
    outlines_m = [footprint(view.camera, view.pose, ground_m) for view in views]
    largest_m = max((float(np.ptp(outline_m, axis=0).max()) for outline_m in outlines_m if len(outline_m)), default=0.0)
    cell_m = max(_COARSE_M, largest_m / _MAX_EDGE_CELLS)
    corner_m = np.min([outline_m.min(axis=0) for outline_m in outlines_m if len(outline_m)] or [[0.0, 0.0]], axis=0)
    cells = [_cells((outline_m - corner_m) / cell_m) for outline_m in outlines_m]
    places = np.unique(np.concatenate(cells)) if cells else np.empty(0, dtype=np.int64)
    rows, columns = np.divmod(places, _ROW_CELLS)
    has_height = np.isfinite(surface.z_m(corner_m[0] + cell_m * columns, corner_m[1] + cell_m * rows))
    if has_height.all():
        return SeenGround(tuple(cells), len(places), len(places))
    known = places[has_height]
    kept = tuple(own[has_height[np.searchsorted(places, own)]] for own in cells)
    return SeenGround(kept, len(known), len(places))


def _cells(outline: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return numbers of the cells within a convex outline, of a raster that has no end; shape (n,)."""
    if not len(outline):
        return np.empty(0, dtype=np.int64)
    first = np.floor(outline.min(axis=0)).astype(np.int64)
    columns, rows = np.ceil(outline.max(axis=0)).astype(np.int64) - first + 1
    inside: NDArray[np.uint8] = np.zeros((rows, columns), dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.rint(outline - first).astype(np.int32), (1,))
    row, column = np.nonzero(inside)
    return np.asarray((first[1] + row) * _ROW_CELLS + first[0] + column, dtype=np.int64)


def ground_height_m(views: Sequence[Placed], surface: FocalSurface) -> float:
    """Return the median height of a surface below cameras; NaN where it is known below none."""
    heights_m = [float(surface.z_m(*view.pose.position_enu_m[:2])) for view in views]
    known = [height_m for height_m in heights_m if np.isfinite(height_m)]
    return float(np.median(known)) if known else float("nan")


def share_without_height(views: Sequence[Placed], terrain: Terrain) -> float:
    """Return the share of the ground in the views of frames that has no height in a terrain."""
    ground_m = ground_height_m(views, terrain)
    if np.isnan(ground_m):
        ground_m = float(np.nanmedian(terrain.heights_m))
    return seen_ground(views, terrain, ground_m).share_unknown
