"""The rasters on which the archive strategy lays masks of the target over each other.

They are square and north-up, lie on the focal plane about the target, and have one middle. Masks are kept on *fine*
cells, as gaps between leaves are often narrower than a cell of the other raster, on which views are weighed against
each other: its cells are four fine ones, each with the share that is seen. Edges are multiples of a fine cell, so that
masks taken with slightly different estimates of the target fit onto each other without interpolation. A mask is a row
of an array, cells row by row from the north-west; the place of a raster is its *anchor*: the fine cell, counted from
the mission's origin, at whose south-western corner its middle lies.
"""

from __future__ import annotations

import base64
import zlib
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.model import TargetMasks

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FINE_CELL_M = 0.05
"""Edge of a fine cell; a camera of 512 pixels and 50 degrees at 35 m has pixels of 0.064 m."""
CELL_M = 2.0 * FINE_CELL_M
"""Edge of a cell of the coarse raster."""
HALF_CELLS = 15
"""Half of the raster's edge: 1.5 m hold the shadow of a standing person seen 35 degrees off the nadir."""
SIDE = 2 * HALF_CELLS
CELLS = SIDE * SIDE
FINE_SIDE = 2 * SIDE
FINE_CELLS = FINE_SIDE * FINE_SIDE

_AXIS_M = FINE_CELL_M * (np.arange(FINE_SIDE) + 0.5 - SIDE)
_EAST_M, _NORTH_M = (axis.ravel() for axis in np.meshgrid(_AXIS_M, -_AXIS_M))


def anchor_of(point_enu_m: FloatArray) -> IntArray:
    """Return the anchor of the raster whose middle is nearest to a point, shape (2,)."""
    return np.rint(np.asarray(point_enu_m) / FINE_CELL_M).astype(np.int64)


def resampled(masks: TargetMasks, anchor: IntArray) -> BoolArray:
    """Return the masks at the centres of fine cells, shape (n, FINE_CELLS); nothing is marked beyond their edges."""
    rows, columns = masks.marked.shape[1:]
    # A centre that rounding leaves on an edge must not fall into either cell at random.
    column = np.floor((_EAST_M + anchor[0] * FINE_CELL_M - masks.west_m) / masks.resolution_m + 1e-6).astype(np.int64)
    row = np.floor((masks.north_m - _NORTH_M - anchor[1] * FINE_CELL_M) / masks.resolution_m + 1e-6).astype(np.int64)
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    marked = np.zeros((len(masks.marked), FINE_CELLS), dtype=np.bool_)
    marked[:, inside] = masks.marked[:, row[inside], column[inside]]
    return marked


def shifted(masks: BoolArray, offsets: IntArray) -> BoolArray:
    """Return masks, shape (n, FINE_CELLS), moved by so many fine cells east and north each, shape (n, 2)."""
    moved = np.zeros_like(masks)
    source, result = masks.reshape(-1, FINE_SIDE, FINE_SIDE), moved.reshape(-1, FINE_SIDE, FINE_SIDE)
    for offset in np.unique(offsets, axis=0):
        east, south = int(offset[0]), -int(offset[1])
        if max(abs(east), abs(south)) >= FINE_SIDE:
            continue
        chosen = (offsets == offset).all(axis=1)
        to_rows, from_rows = _overlap(south)
        to_columns, from_columns = _overlap(east)
        result[chosen, to_rows, to_columns] = source[chosen, from_rows, from_columns]
    return moved


def shares(masks: BoolArray) -> NDArray[np.float32]:
    """Return the share of each coarse cell that masks of fine cells, shape (n, FINE_CELLS), mark, shape (n, CELLS)."""
    fine = masks.view(np.uint8).reshape(-1, SIDE, 2, SIDE, 2)
    counts = fine[:, :, 0, :, 0] + fine[:, :, 0, :, 1] + fine[:, :, 1, :, 0] + fine[:, :, 1, :, 1]
    return np.asarray((np.float32(0.25) * counts.astype(np.float32)).reshape(-1, CELLS))


def quarters(masks: BoolArray) -> BoolArray:
    """Return masks of fine cells, shape (n, FINE_CELLS), by the coarse cell that they lie in, shape (n, CELLS, 4)."""
    return masks.reshape(-1, SIDE, 2, SIDE, 2).transpose(0, 1, 3, 2, 4).reshape(-1, CELLS, 4)


def centroids(masks: TargetMasks) -> tuple[FloatArray, FloatArray]:
    """Return the middle of each vehicle's marked cells, shape (n, 2), and their number, shape (n,).

    The middle of a mask that marks nothing has no meaning.
    """
    rows, columns = masks.marked.shape[1:]
    counts = masks.marked.sum(axis=(1, 2)).astype(np.float64)
    east_m = masks.west_m + masks.resolution_m * (np.arange(columns) + 0.5)
    north_m = masks.north_m - masks.resolution_m * (np.arange(rows) + 0.5)
    sums_m = np.column_stack([masks.marked.sum(axis=1) @ east_m, masks.marked.sum(axis=2) @ north_m])
    return sums_m / np.maximum(counts, 1.0)[:, None], counts


def packed(masks: BoolArray) -> str:
    """Return masks, shape (n, FINE_CELLS), as text that JSON holds: some tens of characters per mask."""
    return base64.b64encode(zlib.compress(np.packbits(masks, axis=None).tobytes(), level=1)).decode("ascii")


@lru_cache(maxsize=2)
def unpacked(text: str, count: int) -> BoolArray:
    """Return the masks of which :func:`packed` made the text, shape (count, FINE_CELLS); not to be written to."""
    bits = np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=np.uint8)
    masks: BoolArray = np.unpackbits(bits, count=count * FINE_CELLS).view(np.bool_).reshape(count, FINE_CELLS)
    masks.flags.writeable = False
    return masks


def _overlap(shift: int) -> tuple[slice, slice]:
    """Return where cells go to, and come from, along an axis."""
    return slice(max(0, shift), FINE_SIDE + min(0, shift)), slice(max(0, -shift), FINE_SIDE + min(0, -shift))
