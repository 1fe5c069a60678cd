"""Holes of elevation models, heights that may be wrong, and the cells that files share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

ZERO_STEP_M: Final = 10.0
"""Step beside a height of exactly 0 m from which on it may be a cell without data."""


@dataclass(frozen=True, slots=True)
class SuspectedHoles:
    """Cells of exactly 0 m that end at a step of more than 10 m: missing data, or a cliff at the sea."""

    count: int
    """Cells of exactly 0 m in the blocks that have such a step."""
    first_deg: tuple[float, float]
    """Latitude and longitude of one of them."""


@dataclass(frozen=True, slots=True)
class Holes:
    """Cells without a height."""

    count: int
    cells: int
    """Number of all cells that were looked at."""
    first_deg: tuple[float, float] | None
    """Latitude and longitude of one of them."""
    suspected: SuspectedHoles | None = None
    """Cells with a height of 0 m that may have none."""


def zeros_at_a_step(heights: NDArray[Any], zero: float = 0.0, reach: int = 1) -> NDArray[np.bool_]:
    """Return which cells are exactly ``zero`` and have a neighbour more than 10 m away from it.

    Args:
        heights: heights of neighbouring cells, NaN in holes, shape (rows, columns).
        zero: what 0 m is written as.
        reach: distance of neighbours in cells.
    """
    zeros = np.asarray(heights == zero)
    if not zeros.any():
        return zeros
    far = (np.abs(heights - zero) > ZERO_STEP_M).astype(np.uint8)
    side = 2 * reach + 1
    return np.asarray(zeros & (cv2.dilate(far, np.ones((side, side), np.uint8)) > 0))


def overlaps(boxes: Sequence[tuple[int, int, int, int]], rows: int) -> Iterator[tuple[range, range]]:
    """Yield the rows and columns that two files share, in bands of some rows.

    Args:
        boxes: first row, first column, end of rows and end of columns of each file, on one grid.
        rows: greatest number of rows of a band.
    """
    for one, other in combinations(boxes, 2):
        top, left = max(one[0], other[0]), max(one[1], other[1])
        bottom, right = min(one[2], other[2]), min(one[3], other[3])
        if left < right:
            for row in range(top, bottom, rows):
                yield range(row, min(bottom, row + rows)), range(left, right)
