"""Errors of the positions of fake vehicles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FakeErrors:
    """Errors of one vehicle's position and altitude: a constant and a slow swing, the same in every run."""

    seed: int
    bias_m: tuple[float, float] = (0.01, 0.02)
    """Standard deviation of the constant, horizontal and vertical."""
    swing_m: tuple[float, float] = (0.005, 0.01)
    """Standard deviation of the swing, horizontal and vertical."""
    period_s: float = 60.0
    climb_mps: float = 0.0
    """Speed at which the estimated height runs away from the true one."""
    climb_from_s: float = 0.0

    @cached_property
    def _drawn(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        rng = np.random.default_rng([self.seed, 0xE5])
        return rng.standard_normal((2, 3)), rng.uniform(0.0, math.tau, (2, 3))

    @cached_property
    def _axes_m(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Constants, and amplitudes of the swing; one row for the estimate, one for the receiver."""
        bias_m, swing_m = (np.array([h_m, h_m, v_m]) for h_m, v_m in (self.bias_m, self.swing_m))
        return self._drawn[0] * bias_m, math.sqrt(2.0) * np.array([swing_m, swing_m])

    def _error_enu_m(self, row: int, now_s: float) -> NDArray[np.float64]:
        constants_m, amplitudes_m = self._axes_m
        swing = np.sin(math.tau * now_s / self.period_s + self._drawn[1][row])
        return np.asarray(constants_m[row] + swing * amplitudes_m[row])

    def estimate_enu_m(self, now_s: float) -> NDArray[np.float64]:
        """What the vehicle believes minus where it is."""
        climbed_m = self.climb_mps * max(0.0, now_s - self.climb_from_s)
        error_enu_m = self._error_enu_m(0, now_s)
        error_enu_m[2] += climbed_m
        return error_enu_m

    def receiver_up_m(self, now_s: float) -> float:
        """Altitude that the satellite receiver measures minus the true one."""
        return float(self._error_enu_m(1, now_s)[2])
