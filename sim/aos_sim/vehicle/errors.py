"""Errors of the simulated vehicles' sensors: what a vehicle believes of its position differs from where it is.

Each vehicle has an estimate that its autopilot flies by, a satellite receiver and a barometer. The error of each is a
constant, drawn once, and a drift: an Ornstein-Uhlenbeck process with a correlation time. Everything is seeded.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FloatArray = NDArray[np.float64]

STEP_S = 0.1
"""Time between two steps of the drift, which is slow."""
_VERTICAL = 2


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Sizes of the errors, standard deviations in metres; those of horizontal positions are per axis."""

    fix_type: int = mavlink.GPS_FIX_TYPE_RTK_FIXED
    """MAVLink's GPS_FIX_TYPE that the receivers report."""
    bias_m: tuple[float, float] = (0.0, 0.0)
    """Constant part of estimate and receiver: horizontal and vertical."""
    drift_m: tuple[float, float] = (0.0, 0.0)
    """Drifting part of estimate and receiver: horizontal and vertical."""
    drift_s: float = 60.0
    """Correlation time of the drift."""
    barometer_m: float = 0.0
    """Drift of the barometer, with the same correlation time."""
    reported_m: tuple[float, float] | None = None
    """Accuracies that the receivers report, horizontal and vertical; None: the true ones."""

    @property
    def accuracy_m(self) -> tuple[float, float]:
        """Horizontal and vertical accuracy that the receivers report."""
        if self.reported_m is not None:
            return self.reported_m
        (bias_h_m, bias_v_m), (drift_h_m, drift_v_m) = self.bias_m, self.drift_m
        return max(0.01, math.hypot(bias_h_m, drift_h_m)), max(0.01, math.hypot(bias_v_m, drift_v_m))


EXACT = SensorErrors()
RTK = SensorErrors(bias_m=(0.01, 0.02), drift_m=(0.01, 0.02), drift_s=30.0, barometer_m=0.2)
GNSS = SensorErrors(
    fix_type=mavlink.GPS_FIX_TYPE_3D_FIX, bias_m=(0.8, 1.5), drift_m=(0.6, 1.0), drift_s=120.0, barometer_m=0.3
)
KINDS: Mapping[str, SensorErrors] = {"exact": EXACT, "rtk": RTK, "gnss": GNSS}


class ErrorProcess:
    """The errors of n vehicles as time goes by.

    Args:
        sizes: how large they are.
        vehicles: n.
        seed: of the draws.
    """

    def __init__(self, sizes: SensorErrors, vehicles: int, seed: int) -> None:
        self.sizes = sizes
        self._rng = np.random.default_rng([seed, 0xE5])
        self._since_step_s = 0.0
        axes_bias_m, axes_drift_m = (np.array([h_m, h_m, v_m]) for h_m, v_m in (sizes.bias_m, sizes.drift_m))
        # Rows: estimate, receiver. A barometer has one axis of its own.
        self._bias_m = self._rng.standard_normal((2, vehicles, 3)) * axes_bias_m
        self._size_m = np.broadcast_to(axes_drift_m, self._bias_m.shape)
        self._drift_m = self._rng.standard_normal(self._bias_m.shape) * self._size_m
        self._barometer_m = self._rng.standard_normal(vehicles) * sizes.barometer_m
        self.climb_mps = np.zeros(vehicles)
        """Speed at which the estimated height runs away from the true one, shape (n,); a fault, such as of a barometer
        that warms up."""
        self._runaway_m = np.zeros(vehicles)

    def advance(self, duration_s: float) -> None:
        """Let time pass."""
        self._runaway_m += duration_s * self.climb_mps
        self._since_step_s += duration_s
        if self._since_step_s < STEP_S:
            return
        decay = math.exp(-self._since_step_s / self.sizes.drift_s)
        noise = math.sqrt(1.0 - decay**2)
        self._drift_m = decay * self._drift_m + noise * self._size_m * self._rng.standard_normal(self._drift_m.shape)
        fresh_m = self.sizes.barometer_m * self._rng.standard_normal(self._barometer_m.shape)
        self._barometer_m = decay * self._barometer_m + noise * fresh_m
        self._since_step_s = 0.0

    @property
    def estimate_enu_m(self) -> FloatArray:
        """What each vehicle believes minus where it is, shape (n, 3)."""
        error_enu_m = self._bias_m[0] + self._drift_m[0]
        error_enu_m[:, _VERTICAL] += self._runaway_m
        return np.asarray(error_enu_m)

    @property
    def receiver_enu_m(self) -> FloatArray:
        """What each satellite receiver measures minus where it is, shape (n, 3)."""
        return np.asarray(self._bias_m[1] + self._drift_m[1])

    @property
    def barometer_m(self) -> FloatArray:
        """Height that each barometer measures minus the true one, shape (n,)."""
        return self._barometer_m
