"""Bilinear sampling at double precision; OpenCV's warps quantise coordinates to 1/32 pixel before version 5."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def bilinear(grid: NDArray[Any], rows: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values of a grid, shape (H, W, ...), at places between its samples, shape (n, ...).

    Args:
        grid: NaN where it is not known, and so is every place that an unknown sample has a share in.
        rows: of the places, shape (n,); places beyond the border have the border's values.
        columns: of the places, shape (n,).
    """
    height, width, *bands = grid.shape
    samples = grid.reshape(height * width, *bands)
    above, to_below, down = _neighbours(rows, height)
    left, to_right, across = _neighbours(columns, width)
    upper_left = above * width + left
    lower_left = upper_left + to_below * width
    trailing = (slice(None), *(np.newaxis,) * len(bands))
    down, across = down[trailing], across[trailing]
    upper = _between(samples.take(upper_left, axis=0), samples.take(upper_left + to_right, axis=0), across)
    lower = _between(samples.take(lower_left, axis=0), samples.take(lower_left + to_right, axis=0), across)
    return _between(upper, lower, down)


def _neighbours(
    places: NDArray[np.float64], size: int
) -> tuple[NDArray[np.intp], NDArray[np.bool_], NDArray[np.float64]]:
    """Return the samples before places, whether the next one has a share in them, and its share."""
    within = np.clip(places, 0.0, size - 1.0)
    before = within.astype(np.intp)
    share = within - before
    return before, share > 0.0, share


def _between(first: NDArray[Any], second: NDArray[Any], share: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(first * (1.0 - share) + second * share, dtype=np.float64)
