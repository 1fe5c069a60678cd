"""Longitudes across the meridian where they end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def unwrapped(longitudes: NDArray[np.float64], about: float, turn: float = 360.0) -> NDArray[np.float64]:
    """Return longitudes within half a turn of another; those that are not finite stay as they are.

    Args:
        longitudes: longitudes in units of which a turn has so many.
        about: longitude to be near to.
        turn: a whole turn.
    """
    with np.errstate(invalid="ignore"):
        turned = longitudes - turn * np.rint((longitudes - about) / turn)
    return np.where(np.isfinite(turned), turned, longitudes)
