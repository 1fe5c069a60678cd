"""Measured discharge of batteries in flight, and what a return takes."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

_WINDOW_S = 120.0
_SAMPLE_S = 2.0
_LEAST_S = 30.0
"""Time in flight before a rate counts: batteries report whole percents."""

DESCENT_MPS = 1.0
"""Speed of a landing; both autopilots are slower near the ground only."""


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


def time_home_s(position_enu_m: NDArray[np.float64], home_enu_m: NDArray[np.float64], cruise_speed_mps: float) -> float:
    """Return the seconds from a position to the ground at home, both of shape (3,): level flight, then descent."""
    beside_m = float(np.hypot(*(position_enu_m - home_enu_m)[:2]))
    above_m = max(0.0, float(position_enu_m[2] - home_enu_m[2]))
    return beside_m / cruise_speed_mps + above_m / DESCENT_MPS
