"""Measured discharge of batteries in flight, and what a return takes."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

_WINDOW_S = 120.0
_SAMPLE_S = 2.0
_LEAST_S = 30.0
"""Time in flight before a rate counts: batteries report whole percents."""

DESCENT_MPS = 1.0
"""Speed of a landing; both autopilots are slower near the ground only."""
CLIMB_MPS = 2.0
"""Speed of a climb to a layer; both autopilots are faster as a rule."""
MANOEUVRES_S = 15.0
"""Time that turning round, coming to a stop above home and touching down take beside the way."""
_LEAST_SPEED = 0.25
"""Share of the cruise speed that is left over the ground against any wind."""


class BatteryMeter:
    """The discharge of one vehicle in flight, from its own reports."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, float]] = deque(maxlen=round(_WINDOW_S / _SAMPLE_S))
        self.per_s: float | None = None
        """Battery fraction that a second of flight costs, over the last two minutes; None until it is known."""

    def take(self, now_s: float, fraction: float) -> None:
        """Note what an airborne vehicle reports; more than one report in two seconds is thinned out."""
        if self._samples and now_s - self._samples[-1][0] < _SAMPLE_S:
            return
        self._samples.append((now_s, fraction))
        if now_s - self._samples[0][0] >= _LEAST_S:
            times_s, fractions = np.array(self._samples).T
            first, second = np.triu_indices(len(times_s), k=1)
            # The median of all slopes (Theil-Sen): one report that jumps must not look like an empty battery.
            slopes_per_s = (fractions[second] - fractions[first]) / (times_s[second] - times_s[first])
            self.per_s = max(0.0, -float(np.median(slopes_per_s)))

    def reset(self) -> None:
        """Discard the samples: the vehicle is on the ground."""
        self._samples.clear()
        self.per_s = None


def time_home_s(
    position_enu_m: NDArray[np.float64],
    home_enu_m: NDArray[np.float64],
    cruise_speed_mps: float,
    *,
    layer_up_m: float = -math.inf,
    wind_mps: float = 0.0,
) -> float:
    """Return the seconds from a position to the ground at home: climb to the layer, level flight, then descent.

    Args:
        position_enu_m: shape (3,).
        home_enu_m: shape (3,).
        cruise_speed_mps: speed over the ground without wind.
        layer_up_m: height of the altitude layer in which it flies home; a vehicle above it does not climb.
        wind_mps: headwind that the way is reckoned against.
    """
    beside_m = float(np.hypot(*(position_enu_m - home_enu_m)[:2]))
    top_m = max(float(position_enu_m[2]), layer_up_m)
    climb_s = (top_m - float(position_enu_m[2])) / CLIMB_MPS
    ground_mps = max(_LEAST_SPEED * cruise_speed_mps, cruise_speed_mps - wind_mps)
    descent_s = max(0.0, top_m - float(home_enu_m[2])) / DESCENT_MPS
    return MANOEUVRES_S + climb_s + beside_m / ground_mps + descent_s
