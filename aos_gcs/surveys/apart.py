"""Positions that no flight has, such as that of a missing fix."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

MAX_APART_M = 100_000.0
"""Distance from the middle of a flight beyond which a position is an error."""


def far_apart(positions_m: Sequence[NDArray[np.float64]]) -> dict[int, str]:
    """Return which positions lie far from the middle of all, by their indices, and what is wrong with them."""
    if not positions_m:
        return {}
    places_m = np.array(positions_m)
    distances_m = np.linalg.norm(places_m - np.median(places_m, axis=0), axis=1)
    return {
        int(index): f"lies {distances_m[index] / 1000.0:,.0f} km from the middle of the flight: correct its position, "
        "or leave it out."
        for index in np.flatnonzero(distances_m > MAX_APART_M)
    }
