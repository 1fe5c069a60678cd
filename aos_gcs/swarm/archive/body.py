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

from aos_gcs.swarm.archive.raster import CELL_M, CELLS, HALF_CELLS, SIDE, BoolArray, FloatArray

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
_LAYER_UP_M = np.float32(LAYER_M) * (np.arange(LAYERS, dtype=np.float32) + np.float32(0.5))
_UP_M, _EAST_M, _NORTH_M = (axis.ravel() for axis in np.meshgrid(_LAYER_UP_M, _AXIS_M, _AXIS_M, indexing="ij"))


@dataclass(frozen=True, slots=True, eq=False)
class VoxelBody:
    """The voxels that the body fills, about the point below it; b of them."""

    voxels: NDArray[np.int64]
    """Shape (b,)."""

    def footprints(self, cells: NDArray[np.int16]) -> BoolArray:
        """Return what the body would cover without forest, shape (n, CELLS), of views that see voxels on these cells.

        Args:
            cells: see :func:`voxel_cells`.
        """
        covered = np.zeros((len(cells), CELLS + 1), dtype=np.bool_)
        np.put_along_axis(covered, cells[:, self.voxels].astype(np.intp), True, axis=1)
        return covered[:, :CELLS]


def learnt_body(
    shown: NDArray[np.float32], cells: NDArray[np.int16], *, prior_height_m: float, prior_radius_m: float
) -> VoxelBody:
    """Return the body that looks speak for; without any, the upright one that is assumed.

    Args:
        shown: masks seen, shape (n, CELLS).
        cells: cells that the looks see the voxels on; see :func:`voxel_cells`.
        prior_height_m: assumed height of the body.
        prior_radius_m: half of its width.
    """
    upright = (np.hypot(_EAST_M, _NORTH_M) <= prior_radius_m) & (prior_height_m >= _UP_M)
    places = cells + np.arange(len(cells), dtype=np.int32)[:, None] * (CELLS + 1)
    hits = np.pad(shown, ((0, 0), (0, 1))).ravel().take(places).sum(axis=0) + PRIOR_LOOKS * upright
    sure = np.partition(hits, len(hits) - SURE_VOXELS)[-SURE_VOXELS:].mean()
    return VoxelBody(np.flatnonzero(hits >= OCCUPIED * sure))


def voxel_cells(slopes: FloatArray, height_m: float, offset_m: FloatArray) -> NDArray[np.int16]:
    """Return the cell that cameras see each voxel on, shape (n, voxels); CELLS for one beyond the raster.

    Args:
        slopes: horizontal distance over height of camera above target, east and north, shape (n, 2).
        height_m: height of the cameras above the focal plane.
        offset_m: from the middle of the raster to the point below the body, shape (2,).
    """
    # Columns depend on the east axis alone and rows on the north axis, layer by layer.
    reach = (height_m / (height_m - _LAYER_UP_M) / CELL_M).astype(np.float32)
    lean = slopes.astype(np.float32)[:, :, None] * (reach * _LAYER_UP_M)
    offset = (offset_m / CELL_M + HALF_CELLS + 1e-4).astype(np.float32)
    east, north = (
        np.floor(reach[:, None] * _AXIS_M + offset[axis] - lean[:, axis, :, None]).astype(np.int16) for axis in (0, 1)
    )
    columns = np.where((east >= 0) & (east < SIDE), east, np.int16(CELLS))
    rows = np.where((north >= 0) & (north < SIDE), (SIDE - 1 - north) * np.int16(SIDE), np.int16(CELLS))
    cells = columns[:, :, :, None] + rows[:, :, None, :]
    return np.asarray(np.minimum(cells, np.int16(CELLS), out=cells).reshape(len(slopes), len(_UP_M)))
