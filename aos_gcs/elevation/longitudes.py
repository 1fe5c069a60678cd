"""Longitudes across the meridian where they end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def unwrapped_deg(longitude_deg: NDArray[np.float64], about_deg: float) -> NDArray[np.float64]:
    """Return longitudes within half a turn of another; as they are where one is not finite."""
    longitude = np.asarray(longitude_deg, dtype=np.float64)
    if not np.isfinite([about_deg, *longitude.ravel()]).all():
        return longitude
    return longitude - 360.0 * np.rint((longitude - about_deg) / 360.0)
