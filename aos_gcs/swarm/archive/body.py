"""The body of the target, learnt from what many frames have shown of it: a soft visual hull.

Which views go well together depends on what each would show of the body if there were no forest. Masks tell only what
is seen, not why the rest is not, so that a hull cannot be carved out of them. But a part of the body is seen as often
as the frames let anything of the target be seen, and a place beside it less often, because it lies before or behind the
body in some views only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive.raster import CELL_M, CELLS, HALF_CELLS, SIDE, BoolArray, FloatArray, IntArray

LAYER_M = 0.2
"""Height of a layer of voxels; under the slopes of the aperture a layer moves by less than a cell."""
LAYERS = 9
HALF_VOXELS = 8
"""Voxels lie so many cells to either side of the target."""
OCCUPIED = 0.7
"""Share of the rate at which the surest voxels are seen from which one belongs to the body."""
SURE_VOXELS = 20
PRIOR_LOOKS = 3.0
"""Weight of the upright body that is assumed at first, in fully visible looks."""

_AXIS_M = CELL_M * np.arange(-HALF_VOXELS, HALF_VOXELS + 1, dtype=np.float32)
_EAST_M, _NORTH_M, _UP_M = (
    axis.ravel()
    for axis in np.meshgrid(
        _AXIS_M, _AXIS_M, np.float32(LAYER_M) * (np.arange(LAYERS) + np.float32(0.5)), indexing="ij"
    )
)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The voxels that the body fills, about the point below it; b of them."""

    voxels: NDArray[np.int64]
    """Shape (b,)."""

    def footprints(self, slopes: FloatArray, height_m: float) -> BoolArray:
        """Return what the body would cover without forest, its foot at the raster's middle, shape (n, CELLS).

        Args:
            slopes: horizontal distance over height of camera above target, east and north, shape (n, 2).
            height_m: height of the cameras above the focal plane.
        """
        covered = np.zeros((len(slopes), CELLS + 1), dtype=np.bool_)
        np.put_along_axis(covered, _cells(slopes, height_m, self.voxels, np.zeros(2)), True, axis=1)
        return covered[:, :CELLS]


def learnt_body(
    shown: NDArray[np.float32],
    slopes: FloatArray,
    height_m: float,
    offset_m: FloatArray,
    *,
    prior_height_m: float,
    prior_radius_m: float,
) -> Body:
    """Return the body that looks speak for; without any, the upright one that is assumed.

    Args:
        shown: masks seen, shape (n, CELLS).
        slopes: slopes of the lines of sight, shape (n, 2).
        height_m: height of the cameras above the focal plane.
        offset_m: from the middle of the masks' raster to the point below the body, shape (2,).
        prior_height_m: assumed height of the body.
        prior_radius_m: half of its width.
    """
    upright = (np.hypot(_EAST_M, _NORTH_M) <= prior_radius_m) & (prior_height_m >= _UP_M)
    cells = _cells(slopes, height_m, np.arange(len(_UP_M)), offset_m)
    hits = np.take_along_axis(np.pad(shown, ((0, 0), (0, 1))), cells, axis=1).sum(axis=0) + PRIOR_LOOKS * upright
    sure = np.partition(hits, len(hits) - SURE_VOXELS)[-SURE_VOXELS:].mean()
    return Body(np.flatnonzero(hits >= OCCUPIED * sure))


def _cells(slopes: FloatArray, height_m: float, voxels: IntArray, offset_m: FloatArray) -> IntArray:
    """Return the cell that each voxel lies on as cameras see it, shape (n, voxels); CELLS beyond the raster."""
    up_m = _UP_M[voxels]
    reach = (height_m / (height_m - up_m) / CELL_M).astype(np.float32)
    east, north = reach * _EAST_M[voxels], reach * _NORTH_M[voxels]
    lean = reach * up_m
    slopes, offset = slopes.astype(np.float32), (offset_m / CELL_M + HALF_CELLS + 1e-4).astype(np.float32)
    column = np.floor(east + offset[0] - slopes[:, :1] * lean).astype(np.int32)
    row = SIDE - 1 - np.floor(north + offset[1] - slopes[:, 1:] * lean).astype(np.int32)
    inside = (column >= 0) & (column < SIDE) & (row >= 0) & (row < SIDE)
    return np.where(inside, row * SIDE + column, CELLS)
