"""Errors of positions: what a vehicle believes of its position differs from where it is.

Each vehicle has an estimate that its autopilot flies by, a satellite receiver and a barometer. The error of each is a
constant, drawn once, a drift (a Gauss-Markov process), and white noise. Everything is seeded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.errors.sizes import FloatArray, check_sizes, drifted

STEP_S = 0.1
"""Time between two steps of the drift, which is slow, and between two values of the white noise."""
_VERTICAL = 2
_LEAST_ACCURACY_M = 0.01


@dataclass(frozen=True, slots=True)
class PositionErrors:
    """Sizes of the errors, standard deviations in metres; those of horizontal positions are per axis.

    Raises:
        ConfigurationError: a value is negative.
    """

    fix_type: int = mavlink.GPS_FIX_TYPE_RTK_FIXED
    """MAVLink's GPS_FIX_TYPE that the receivers report."""
    bias_m: tuple[float, float] = (0.0, 0.0)
    """Constant part of estimate and receiver: horizontal and vertical."""
    drift_m: tuple[float, float] = (0.0, 0.0)
    """Drifting part of estimate and receiver: horizontal and vertical."""
    drift_s: float = 60.0
    """Correlation time of the drift."""
    white_m: tuple[float, float] = (0.0, 0.0)
    """White part of estimate and receiver: horizontal and vertical."""
    smoothing_s: float = 0.0
    """Time over which an autopilot smooths the estimate that it steers by; 0: not at all. Its filter follows satellites
    alone more slowly than corrected positions: one that followed their noise at once would shake the vehicle."""
    barometer_m: float = 0.0
    """Drift of the barometer, with the same correlation time."""
    reported_m: tuple[float, float] | None = None
    """Accuracies that the receivers report, horizontal and vertical; None: the true ones."""

    def __post_init__(self) -> None:
        check_sizes(self, "position", positive=("drift_s",))

    @property
    def accuracy_m(self) -> tuple[float, float]:
        """Horizontal and vertical accuracy that the receivers report."""
        if self.reported_m is not None:
            return self.reported_m
        parts_m = zip(self.bias_m, self.drift_m, self.white_m, strict=True)
        horizontal_m, vertical_m = (max(_LEAST_ACCURACY_M, math.hypot(*axis_m)) for axis_m in parts_m)
        return horizontal_m, vertical_m


class PositionProcess:
    """The position errors of n vehicles as time goes by.

    Args:
        sizes: how large they are.
        vehicles: n.
        seed: of the draws; equal ones give equal draws up to the sizes.
    """

    def __init__(self, sizes: PositionErrors, vehicles: int, seed: int) -> None:
        self.sizes = sizes
        self._rng = np.random.default_rng([seed, 0xE5])
        self._white_rng = np.random.default_rng([seed, 0xE6])
        self._since_step_s = 0.0
        bias_m, drift_m, white_m = (
            np.array([horizontal_m, horizontal_m, vertical_m])
            for horizontal_m, vertical_m in (sizes.bias_m, sizes.drift_m, sizes.white_m)
        )
        # Rows: estimate, receiver. A barometer has one axis of its own.
        self._bias_m = self._rng.standard_normal((2, vehicles, 3)) * bias_m
        self._drift_size_m, self._white_size_m = drift_m, white_m
        self._drift_m = self._rng.standard_normal(self._bias_m.shape) * drift_m
        self._barometer_m = self._rng.standard_normal(vehicles) * sizes.barometer_m
        self._white_m = self._white_rng.standard_normal(self._bias_m.shape) * white_m
        self._steered_m = self._bias_m[0] + self._drift_m[0]
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
        passed_s, correlation_s = self._since_step_s, self.sizes.drift_s
        self._drift_m = drifted(self._rng, self._drift_m, self._drift_size_m, passed_s, correlation_s)
        self._barometer_m = drifted(self._rng, self._barometer_m, self.sizes.barometer_m, passed_s, correlation_s)
        self._white_m = self._white_rng.standard_normal(self._white_m.shape) * self._white_size_m
        self._since_step_s = 0.0
        share = passed_s / (passed_s + self.sizes.smoothing_s)
        self._steered_m = self._steered_m + share * (self._believed_m() - self._steered_m)

    def _believed_m(self) -> FloatArray:
        """Return the estimate's error but for what runs away, shape (n, 3)."""
        return np.asarray(self._bias_m[0] + self._drift_m[0] + self._white_m[0])

    @property
    def steered_enu_m(self) -> FloatArray:
        """What each autopilot takes its position for, smoothed, minus where it is, shape (n, 3)."""
        if self.sizes.smoothing_s == 0.0:
            return self.estimate_enu_m
        return self._with_runaway(self._steered_m)

    def _with_runaway(self, error_enu_m: FloatArray) -> FloatArray:
        result = error_enu_m.copy()
        result[:, _VERTICAL] += self._runaway_m
        return result

    @property
    def estimate_enu_m(self) -> FloatArray:
        """What each vehicle believes minus where it is, shape (n, 3)."""
        return self._with_runaway(self._believed_m())

    @property
    def receiver_enu_m(self) -> FloatArray:
        """What each satellite receiver measures minus where it is, shape (n, 3)."""
        return np.asarray(self._bias_m[1] + self._drift_m[1] + self._white_m[1])

    @property
    def barometer_m(self) -> FloatArray:
        """Height that each barometer measures minus the true one, shape (n,)."""
        return self._barometer_m
