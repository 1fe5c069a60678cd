"""Agreement of frames on a blob: marks of several within a body's half width, as errors of poses part them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import FocalGrid
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.marking import MarkedFrame

AGREEMENT_M = 0.3
"""Distance from a place within which a frame marks it: half the width of a body."""


def agreeing_frames(cells: BlobCells, grid: FocalGrid, marked: Sequence[MarkedFrame]) -> int:
    """Return the largest number of frames that mark one place of a blob, each within :data:`AGREEMENT_M`."""
    # A square with the area of a circle.
    half = round(AGREEMENT_M / grid.resolution_m * math.sqrt(math.pi) / 2.0)
    kernel = np.ones((2 * half + 1, 2 * half + 1), dtype=np.uint8)
    top, left = int(cells.rows.min()) - half, int(cells.columns.min()) - half
    shape = int(np.ptp(cells.rows)) + 2 * half + 1, int(np.ptp(cells.columns)) + 2 * half + 1
    count: NDArray[np.uint16] = np.zeros(shape, dtype=np.uint16)
    for one in marked:
        rows, columns = one.marks.rows - top, one.marks.columns - left
        inside = (rows >= 0) & (rows < shape[0]) & (columns >= 0) & (columns < shape[1])
        if inside.any():
            own: NDArray[np.uint8] = np.zeros(shape, dtype=np.uint8)
            own[rows[inside], columns[inside]] = 1
            count += np.asarray(cv2.dilate(own, kernel), dtype=np.uint8)
    return int(count[cells.rows - top, cells.columns - left].max())
