"""Errors of the positions of fake vehicles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class _Swing(NamedTuple):
    """A constant and a slow swing about it."""

    constant_m: float
    amplitude_m: float
    period_s: float
    phase_rad: float

    def at(self, now_s: float) -> float:
        return self.constant_m + self.amplitude_m * math.sin(math.tau * now_s / self.period_s + self.phase_rad)


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
    def _swings(self) -> tuple[tuple[_Swing, ...], tuple[_Swing, ...]]:
        """Errors of the estimate and of the receiver; one number at a time, which takes a fifth of what arrays take."""
        rng = np.random.default_rng([self.seed, 0xE5])
        drawn, phases = rng.standard_normal((2, 3)).tolist(), rng.uniform(0.0, math.tau, (2, 3)).tolist()
        biases_m = (self.bias_m[0], self.bias_m[0], self.bias_m[1])
        amplitudes_m = [math.sqrt(2.0) * swing_m for swing_m in (self.swing_m[0], self.swing_m[0], self.swing_m[1])]
        estimate, receiver = (
            tuple(
                _Swing(share * bias_m, amplitude_m, self.period_s, phase)
                for share, bias_m, amplitude_m, phase in zip(*each, strict=True)
            )
            for each in zip(drawn, (biases_m,) * 2, (amplitudes_m,) * 2, phases, strict=True)
        )
        return estimate, receiver

    def estimate_enu_m(self, now_s: float) -> NDArray[np.float64]:
        """What the vehicle believes minus where it is."""
        east, north, _ = self._swings[0]
        return np.array((east.at(now_s), north.at(now_s), self.estimate_up_m(now_s)))

    def estimate_up_m(self, now_s: float) -> float:
        """Height that the vehicle believes to have minus its own."""
        return self._swings[0][2].at(now_s) + self.climb_mps * max(0.0, now_s - self.climb_from_s)

    def receiver_up_m(self, now_s: float) -> float:
        """Altitude that the satellite receiver measures minus the true one."""
        return self._swings[1][2].at(now_s)
