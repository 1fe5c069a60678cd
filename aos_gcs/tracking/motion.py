"""Motion of a target: an interacting-multiple-model filter of a still and a walking person.

Most targets of a search lie or stand, and their position should be averaged without end; some walk, and averaging
would leave the estimate behind. Two Kalman filters run side by side and are mixed by how well each predicts
(Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to Tracking and Navigation*, section 11.6):

- still: the position stays, but for a small diffusion; the velocity is zero;
- walking: constant velocity, disturbed by white noise of the acceleration.

The still filter knows nothing of a velocity. Where its share enters the walking one, the velocity is that of a person
who has just begun to walk, of zero mean and ``walking_speed_mps`` along each axis; without it the walking filter would
believe in its zero velocity and be slow to follow.

The state is (east, north, east velocity, north velocity). All functions are pure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError

STILL, WALKING = 0, 1
"""Rows of the arrays of a :class:`Motion`."""

_MEASURED = np.eye(2, 4)


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """Motion of targets.

    Raises:
        ConfigurationError: a value is not finite or not above 0; the text names it.
    """

    walking_speed_mps: float = 2.0
    """Standard deviation along each axis of the velocity of a target that walks, before it is known."""
    acceleration_m2ps3: float = 0.05
    """Power spectral density of a walker's acceleration: its velocity changes by 0.22 m/s in a second (1 sigma)."""
    diffusion_m2ps: float = 1e-4
    """Diffusion of a still target: 0.08 m in a minute."""
    still_s: float = 300.0
    """Mean time for which a still target stays still."""
    walking_s: float = 60.0
    """Mean time for which a walker keeps walking."""

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(f"{name} must be a finite number above 0, but is {value}.")


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Estimate of a target's motion at one moment; row 0 of the still model, row 1 of the walking one."""

    at_s: float
    means: NDArray[np.float64]
    """Shape (2, 4)."""
    covariances: NDArray[np.float64]
    """Shape (2, 4, 4)."""
    shares: NDArray[np.float64]
    """Probability of each model, shape (2,)."""

    @property
    def state(self) -> NDArray[np.float64]:
        """Mean over the models, shape (4,)."""
        return np.asarray(self.shares @ self.means)

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance over the models, their difference included, shape (4, 4)."""
        return _mixed(self.means, self.covariances, self.shares)[1]


def begin(
    position_enu_m: NDArray[np.float64], covariance_m2: NDArray[np.float64], at_s: float, settings: MotionSettings
) -> Motion:
    """Return the motion of a target seen once, at a position, shape (2,), with its covariance, shape (2, 2)."""
    means = np.tile([*position_enu_m, 0.0, 0.0], (2, 1))
    covariances = np.zeros((2, 4, 4))
    covariances[:, :2, :2] = covariance_m2
    covariances[WALKING, 2:, 2:] = settings.walking_speed_mps**2 * np.eye(2)
    return Motion(at_s, means, covariances, np.full(2, 0.5))


def predict(motion: Motion, to_s: float, settings: MotionSettings) -> Motion:
    """Return the motion at a later moment, or the same one; time never runs backwards."""
    duration_s = to_s - motion.at_s
    if duration_s <= 0.0:
        return motion
    joint = motion.shares[:, np.newaxis] * _changes(duration_s, settings)
    shares = joint.sum(axis=0)
    before = motion.covariances.copy()
    before[STILL, 2:, 2:] = settings.walking_speed_mps**2 * np.eye(2)
    means, covariances = np.empty_like(motion.means), np.empty_like(before)
    for model in (STILL, WALKING):
        mean, covariance = _mixed(motion.means, before, joint[:, model] / shares[model])
        F, Q = _transition(model, duration_s, settings)
        means[model] = F @ mean
        covariances[model] = F @ covariance @ F.T + Q
    return Motion(to_s, means, covariances, shares)


def density(motion: Motion, position_enu_m: NDArray[np.float64], covariance_m2: NDArray[np.float64]) -> float:
    """Return how densely a measurement is expected at a position, per square metre; arguments as of :func:`update`."""
    logs = [_log_density(motion, model, position_enu_m, covariance_m2) for model in (STILL, WALKING)]
    return float(motion.shares @ np.exp(logs))


def update(motion: Motion, position_enu_m: NDArray[np.float64], covariance_m2: NDArray[np.float64]) -> Motion:
    """Return the motion after a measurement at its moment: a position, shape (2,), and its covariance, shape (2, 2)."""
    means, covariances, logs = np.empty_like(motion.means), np.empty_like(motion.covariances), np.empty(2)
    for model in (STILL, WALKING):
        P = motion.covariances[model]
        K = np.linalg.solve(P[:2, :2] + covariance_m2, P[:2]).T
        means[model] = motion.means[model] + K @ (position_enu_m - motion.means[model, :2])
        kept = np.eye(4) - K @ _MEASURED
        covariances[model] = kept @ P @ kept.T + K @ covariance_m2 @ K.T  # Joseph's form stays positive
        logs[model] = _log_density(motion, model, position_enu_m, covariance_m2)
    weights = motion.shares * np.exp(logs - logs.max())
    return Motion(motion.at_s, means, covariances, weights / weights.sum())


def _log_density(
    motion: Motion, model: int, position_enu_m: NDArray[np.float64], covariance_m2: NDArray[np.float64]
) -> float:
    innovation_m = position_enu_m - motion.means[model, :2]
    S = motion.covariances[model, :2, :2] + covariance_m2
    squared = float(innovation_m @ np.linalg.solve(S, innovation_m))
    return -0.5 * (squared + float(np.linalg.slogdet(S).logabsdet)) - math.log(2.0 * math.pi)


def _changes(duration_s: float, settings: MotionSettings) -> NDArray[np.float64]:
    """Return the probability of each change of model, shape (2, 2), from rows to columns."""
    sets_out_hz, stops_hz = 1.0 / settings.still_s, 1.0 / settings.walking_s
    settled = np.array([stops_hz, sets_out_hz]) / (sets_out_hz + stops_hz)
    return np.asarray(settled + math.exp(-(sets_out_hz + stops_hz) * duration_s) * (np.eye(2) - settled))


@lru_cache(maxsize=4)
def _transition(
    model: int, duration_s: float, settings: MotionSettings
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the transition matrix and the process noise, both of shape (4, 4): the same for all tracks of a step."""
    t, eye = duration_s, np.eye(2)
    if model == STILL:
        return np.diag([1.0, 1.0, 0.0, 0.0]), np.diag([settings.diffusion_m2ps * t] * 2 + [0.0, 0.0])
    noise = settings.acceleration_m2ps3 * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    return np.kron(np.array([[1.0, t], [0.0, 1.0]]), eye).astype(np.float64), np.kron(noise, eye).astype(np.float64)


def _mixed(
    means: NDArray[np.float64], covariances: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return mean and covariance of a mixture of normal distributions."""
    mean = weights @ means
    apart = means - mean
    spread = apart[:, :, np.newaxis] * apart[:, np.newaxis, :]
    covariance: NDArray[np.float64] = np.tensordot(weights, covariances + spread, axes=1)
    return mean, covariance
