"""Expected views along lines of sight that no drone has looked along yet."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive.raster import BoolArray, FloatArray

PRIOR_WEIGHT = 0.3
"""Weight of the prior expectation, in looks."""
KNOWN = 0.9
"""Weight of a look for a spot from which the spot is not worth another look of its own."""

NEGLIGIBLE = 1e-4
"""Weight of a look below which it does not count."""


@lru_cache(maxsize=8)
def lattice(radius_m: float, pitch_m: float) -> FloatArray:
    """Return the points of a triangular lattice within a circle about the origin, shape (n, 2)."""
    reach = int(2.0 * radius_m / pitch_m) + 2
    column, row = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    points = pitch_m * np.column_stack([(column + 0.5 * row).ravel(), (np.sqrt(0.75) * row).ravel()])
    points = np.asarray(points[np.linalg.norm(points, axis=1) <= radius_m])
    points.flags.writeable = False
    return points


def kernel(distances_m: FloatArray, width_m: float) -> FloatArray:
    """Return how much lines of sight at these distances tell about each other, from 0 to 1."""
    return np.asarray(np.exp(-0.5 * (distances_m / width_m) ** 2))


def likeness(first_m: FloatArray, second_m: FloatArray, width_m: float) -> NDArray[np.float32]:
    """Return the kernel of the distances of points, shapes (n, d) and (k, d), in a fast way, shape (n, k)."""
    middle_m = first_m.mean(axis=0)
    first, second = (((points - middle_m) / width_m).astype(np.float32) for points in (first_m, second_m))
    # |a - b|^2, multiplied out.
    exponents = first @ second.T
    exponents -= 0.5 * (first**2).sum(axis=1)[:, None]
    exponents -= 0.5 * (second**2).sum(axis=1)
    weights = np.exp(exponents, out=exponents)
    # Numbers near zero mean nothing, and those below 1e-38 take a processor ten times as long.
    weights[weights < NEGLIGIBLE] = 0.0
    return np.asarray(weights)


def expected_masks(
    weights: NDArray[np.float32], masks: NDArray[np.float32], footprints: BoolArray, hope: float
) -> NDArray[np.float32]:
    """Return the probability of each cell to be seen along lines nobody has looked along: kernel regression.

    Args:
        weights: weights of k looks for p lines, shape (p, k).
        masks: masks of the looks, shape (k, cells).
        footprints: view along the lines without forest, shape (p, cells).
        hope: share of it that a line is expected to show of which nothing is known.
    """
    evidence = weights @ masks + np.float32(PRIOR_WEIGHT * hope) * footprints
    return np.asarray(np.minimum(evidence / (weights.sum(axis=1) + np.float32(PRIOR_WEIGHT))[:, None], np.float32(1.0)))
