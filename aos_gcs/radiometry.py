"""Temperatures in image files: 16-bit pixels in hundredths of a kelvin, as radiometric thermal cameras write them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

CENTIKELVIN_PER_KELVIN = 100
ZERO_CELSIUS_K = 273.15


def celsius_from_centikelvin(thermal_ck: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Return temperatures in degrees Celsius, any shape.

    The one place where this is computed: a replay must read the very numbers that the mission has seen.
    """
    return thermal_ck.astype(np.float32) / np.float32(CENTIKELVIN_PER_KELVIN) - np.float32(ZERO_CELSIUS_K)


def centikelvin_from_celsius(thermal_c: NDArray[np.floating[Any]]) -> NDArray[np.uint16]:
    """Inverse of :func:`celsius_from_centikelvin`, to the nearest hundredth; saturates outside of 0 to 655.35 K.

    Not-a-number becomes 0.
    """
    # In place: new memory takes longer than the sums.
    thermal_ck = thermal_c.astype(np.float64)
    thermal_ck += ZERO_CELSIUS_K
    thermal_ck *= CENTIKELVIN_PER_KELVIN
    np.nan_to_num(np.rint(thermal_ck, out=thermal_ck), copy=False)
    return np.asarray(np.clip(thermal_ck, 0, 65535, out=thermal_ck), dtype=np.uint16)
