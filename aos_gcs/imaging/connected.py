"""Cells of a lattice that belong together because they are near one another."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Offsets = list[tuple[int, int]]
"""Rows and columns from a cell to those that it is connected with; of two opposite ones one only."""


def connected(
    rows: NDArray[np.intp] | NDArray[np.float64], columns: NDArray[np.intp] | NDArray[np.float64], offsets: Offsets
) -> NDArray[np.intp]:
    """Return the number of the set that each cell belongs to, shape (n,); sets are numbered by their first cells.

    Args:
        rows: whole numbers, of cells of which none is there twice, shape (n,).
        columns: of the cells, shape (n,).
        offsets: as :func:`within_square` and :func:`within_disc` return them.
    """
    reach = max(max(abs(row), abs(column)) for row, column in offsets)
    near_rows, near_columns = _without_gaps(rows, reach), _without_gaps(columns, reach)
    width = int(near_columns.max()) + 1 + reach
    keys = near_rows * width + near_columns
    order = np.argsort(keys, kind="stable")
    sorted_keys = keys[order]
    pairs = [_neighbours(sorted_keys, row * width + column) for row, column in offsets]
    first, second = order[np.concatenate(pairs, axis=1)]
    return np.unique(_lowest(first, second, len(rows)), return_inverse=True)[1]


def within_square(reach: int) -> Offsets:
    """Return the offsets to cells that are at most so many rows and columns away."""
    return [(row, column) for row in range(reach + 1) for column in range(-reach, reach + 1) if (row, column) > (0, 0)]


def within_disc(radius: float) -> Offsets:
    """Return the offsets to cells that are at most so far away, in cells."""
    return [offset for offset in within_square(math.floor(radius)) if math.hypot(*offset) <= radius]


def _without_gaps(numbers: NDArray[np.intp] | NDArray[np.float64], reach: int) -> NDArray[np.intp]:
    """Return numbers from 0 on with the same distances up to ``reach``, and with larger ones shortened.

    Cells may be anywhere: a row and a column of a few huge ones would not fit into one integer.
    """
    used, index = np.unique(numbers, return_inverse=True)
    steps = np.minimum(np.diff(used, prepend=used[:1]), reach + 1)
    return np.cumsum(steps).astype(np.intp)[index]


def _neighbours(keys: NDArray[np.intp], offset: int) -> NDArray[np.intp]:
    """Return the places, shape (2, k), of sorted keys and of those that are larger by an offset."""
    at = np.searchsorted(keys, keys + offset)
    found = np.flatnonzero(keys[np.minimum(at, len(keys) - 1)] == keys + offset)
    return np.stack((found, at[found]))


def _lowest(first: NDArray[np.intp], second: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Return for each of ``count`` cells the lowest one that pairs of cells connect it with, however many there are."""
    lowest = np.arange(count)
    while True:
        ends = np.minimum(lowest[first], lowest[second])
        before = lowest.copy()
        # The sets of both ends have the lower of both for their own first cell, and so has every cell in them.
        np.minimum.at(lowest, before[first], ends)
        np.minimum.at(lowest, before[second], ends)
        while (lowest != (following := lowest[lowest])).any():
            lowest = following
        if (lowest == before).all():
            return lowest
