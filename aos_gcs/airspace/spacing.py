"""Places that keep vehicles apart: spots to land on, and positions moved aside."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.separation import TOLERANCE_M

FloatArray = NDArray[np.float64]

_SPREAD_EXCESS = 0.01
_REACH_M = 40.0
_STEP_M = 0.5


def landing_spots(centre_enu_m: Sequence[float], n: int, spacing_m: float) -> FloatArray:
    """Return n spots on a square grid around a point, shape (n, 2), the nearest first; more spots begin like fewer.

    Args:
        centre_enu_m: shape (2,), metres.
        n: number of spots, 0 or more.
        spacing_m: distance between neighbours.
    """
    reach = math.isqrt(max(n, 1)) + 1
    steps = np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    # Ties by angle, so that the order is the same everywhere.
    order = np.lexsort((np.arctan2(grid[:, 1], grid[:, 0]), (grid**2).sum(axis=1)))
    return np.asarray(np.asarray(centre_enu_m, dtype=np.float64) + spacing_m * grid[order[:n]])


def spread_apart(positions_enu_m: FloatArray, separation_m: float) -> FloatArray:
    """Return positions, shape (n, 3), moved sideways until all horizontal distances are ``separation_m`` or more.

    Heights stay. Pairs that are too close are pushed apart by equal amounts, again and again; vehicles exactly above
    one another part in a direction that follows from their rows. Positions that are far enough apart are returned
    unchanged.
    """
    positions_m = np.array(positions_enu_m, dtype=np.float64)
    first, second = np.triu_indices(len(positions_m), k=1)
    # Each pair gets a direction of its own, for the golden angle never repeats one.
    angles_rad = 2.399963229728653 * np.arange(1, len(first) + 1)
    fallback = np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
    while True:
        offsets_m = positions_m[second, :2] - positions_m[first, :2]
        distances_m = np.linalg.norm(offsets_m, axis=1)
        close = distances_m < separation_m
        if not close.any():
            return positions_m
        stacked = distances_m < TOLERANCE_M
        units = np.where(stacked[:, None], fallback, offsets_m / np.where(stacked, 1.0, distances_m)[:, None])
        # Slightly too far, so that a finite number of rounds suffices.
        push_m = 0.5 * ((1.0 + _SPREAD_EXCESS) * separation_m - distances_m[close])[:, None] * units[close]
        np.add.at(positions_m[:, :2], second[close], push_m)
        np.add.at(positions_m[:, :2], first[close], -push_m)


def nearest_free(
    place_m: FloatArray,
    taken_m: FloatArray,
    clear_m: FloatArray,
    is_admissible: Callable[[FloatArray], NDArray[np.bool_]],
) -> FloatArray | None:
    """Return the place nearest to another that keeps clear of places taken, shape (2,); None where none is near.

    Args:
        place_m: shape (2,), metres.
        taken_m: places to keep clear of, shape (k, 2).
        clear_m: distance to keep from each, shape (k,).
        is_admissible: returns which of many places, shape (n, 2), are admissible otherwise.
    """
    candidates_m = place_m + _offsets_m()
    offsets_m = candidates_m[:, None] - np.asarray(taken_m, dtype=np.float64).reshape(-1, 2)
    is_free = (np.linalg.norm(offsets_m, axis=-1) >= clear_m).all(axis=1)
    free_m = candidates_m[is_free]
    admissible_m = free_m[is_admissible(free_m)] if len(free_m) else free_m
    return np.asarray(admissible_m[0]) if len(admissible_m) else None


@lru_cache(maxsize=1)
def _offsets_m() -> FloatArray:
    """Return the offsets of places about a place, shape (n, 2), the nearest first; ties by angle."""
    steps_m = np.arange(-_REACH_M, _REACH_M + _STEP_M, _STEP_M)
    grid_m = np.stack(np.meshgrid(steps_m, steps_m), axis=-1).reshape(-1, 2)
    distances_m = np.hypot(*grid_m.T)
    order = np.lexsort((np.arctan2(grid_m[:, 1], grid_m[:, 0]), distances_m))
    return np.asarray(grid_m[order[distances_m[order] <= _REACH_M]])
