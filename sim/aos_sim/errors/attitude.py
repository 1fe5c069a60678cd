"""Errors of attitudes: roll, pitch and heading that an autopilot believes, minus the true ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aos_sim.errors.sizes import FloatArray, check_sizes, drifted

_STEP_S = 0.1


@dataclass(frozen=True, slots=True)
class AttitudeErrors:
    """Sizes of the errors, standard deviations; those of roll and pitch are per axis.

    Raises:
        ConfigurationError: a value is negative.
    """

    tilt_bias_rad: float = 0.0
    """Constant part of roll and pitch: how the autopilot is mounted, and its accelerometers."""
    tilt_drift_rad: float = 0.0
    heading_bias_rad: float = 0.0
    """Constant part of the heading: iron near the compass."""
    heading_drift_rad: float = 0.0
    drift_s: float = 60.0
    """Correlation time of the drifts."""

    def __post_init__(self) -> None:
        check_sizes(self, "attitude", positive=("drift_s",))


class AttitudeProcess:
    """The attitude errors of n vehicles as time goes by.

    Args:
        sizes: how large they are.
        vehicles: n.
        seed: of the draws; equal ones give equal draws up to the sizes.
    """

    def __init__(self, sizes: AttitudeErrors, vehicles: int, seed: int) -> None:
        self._rng = np.random.default_rng([seed, 0xA7])
        self._correlation_s = sizes.drift_s
        self._since_step_s = 0.0
        bias_rad = np.array([sizes.tilt_bias_rad, sizes.tilt_bias_rad, sizes.heading_bias_rad])
        self._drift_size_rad = np.array([sizes.tilt_drift_rad, sizes.tilt_drift_rad, sizes.heading_drift_rad])
        self._bias_rad = self._rng.standard_normal((vehicles, 3)) * bias_rad
        self._drift_rad = self._rng.standard_normal((vehicles, 3)) * self._drift_size_rad

    def advance(self, duration_s: float) -> None:
        """Let time pass."""
        self._since_step_s += duration_s
        if self._since_step_s < _STEP_S:
            return
        self._drift_rad = drifted(
            self._rng, self._drift_rad, self._drift_size_rad, self._since_step_s, self._correlation_s
        )
        self._since_step_s = 0.0

    @property
    def estimate_rad(self) -> FloatArray:
        """Roll, pitch and heading that each autopilot believes minus the true ones, shape (n, 3)."""
        return np.asarray(self._bias_rad + self._drift_rad)
