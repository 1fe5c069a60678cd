"""The ask/tell interface of the optimisers, what their states hold, and schedules of parameters.

An optimiser is an immutable object with its parameters; its state is data outside of it, so that a run can be saved,
replayed and forked. Randomness is an argument. Values are minimised; one that is not a number never counts as best.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class Schedule:
    """A parameter that is constant, or changes linearly over the first ``steps`` steps and then stays."""

    start: float
    end: float | None = None
    """None: constant."""
    steps: int = 1

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise ConfigurationError(f"steps of a schedule must be at least 1, but is {self.steps}.")

    def at(self, step: int) -> float:
        """Return the value for the move number ``step``, counted from 0."""
        if self.end is None:
            return self.start
        return self.start + (self.end - self.start) * min(step / self.steps, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """The particles of a swarm with what they remember; n particles in a space of ``dim`` dimensions."""

    positions: NDArray[np.float64]
    """x_i, shape (n, dim)."""
    velocities: NDArray[np.float64]
    """v_i, shape (n, dim)."""
    best_positions: NDArray[np.float64]
    """p_i, the personal bests, shape (n, dim)."""
    best_values: NDArray[np.float64]
    """f(p_i), shape (n,); infinite before the first value."""
    moves: int = 0
    """Number of moves of the particles."""
    told: bool = False
    """The values at the start are known; until then the positions to evaluate are those of the start."""
    awaits_tell: bool = False
    """Positions were asked for whose values have not been told."""

    @property
    def leader(self) -> int:
        """Row of the particle that has found the global best."""
        return int(self.best_values.argmin())

    @property
    def best_position(self) -> NDArray[np.float64]:
        """The global best g, shape (dim,)."""
        best: NDArray[np.float64] = self.best_positions[self.leader]
        return best

    @property
    def best_value(self) -> float:
        """The value at the global best."""
        return float(self.best_values[self.leader])


def start_particles(positions: NDArray[np.float64], velocities: NDArray[np.float64] | None = None) -> Particles:
    """Return particles at rest, or with the velocities given, before their first evaluation.

    Raises:
        ValueError: the shapes are not (n, dim) with n of at least 2, or a number is not finite.
    """
    x = np.array(positions, dtype=np.float64)
    v = np.zeros_like(x) if velocities is None else np.array(velocities, dtype=np.float64)
    if x.ndim != 2 or len(x) < 2 or v.shape != x.shape:
        raise ValueError(
            f"positions and velocities need one shape (n, dim) with n >= 2, but have {x.shape} and {v.shape}"
        )
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise ValueError("positions and velocities must be finite")
    return Particles(x, v, x.copy(), np.full(len(x), np.inf))


def remembered(particles: Particles, values: NDArray[np.float64]) -> Particles:
    """Return the particles with personal bests brought up to date by the values at their positions, shape (n,).

    Raises:
        RuntimeError: no positions have been asked for since the last values.
        ValueError: there is not one value per particle.
    """
    if not particles.awaits_tell:
        raise RuntimeError("tell() needs positions asked for first: call ask() before each tell()")
    if np.shape(values) != particles.best_values.shape:
        raise ValueError(f"values need shape {particles.best_values.shape}, but have {np.shape(values)}")
    improved = values < particles.best_values
    return replace(
        particles,
        best_positions=np.where(improved[:, None], particles.positions, particles.best_positions),
        best_values=np.where(improved, values, particles.best_values),
        told=True,
        awaits_tell=False,
    )


def forgetful(particles: Particles) -> Particles:
    """Return the particles without their memories, for an objective that has just changed.

    The next values told become the personal bests; until then the particles are drawn to where they are.
    """
    return replace(
        particles, best_positions=particles.positions.copy(), best_values=np.full(len(particles.positions), np.inf)
    )


StateT = TypeVar("StateT")


class Optimiser(Protocol[StateT]):
    """A particle swarm optimiser: ``init`` once, then ``ask`` and ``tell`` in turn."""

    def init(self, positions: NDArray[np.float64], velocities: NDArray[np.float64] | None = None) -> StateT:
        """Return the state before the first evaluation.

        Args:
            positions: the start, shape (n, dim), n >= 2.
            velocities: at the start, the same shape; None for particles at rest.

        Raises:
            ValueError: shapes do not fit, or a number is not finite.
        """
        ...

    def ask(self, state: StateT, rng: np.random.Generator) -> tuple[NDArray[np.float64], StateT]:
        """Return the positions to evaluate next, shape (k, dim), and the new state.

        Raises:
            RuntimeError: the values of the latest positions have not been told.
        """
        ...

    def tell(self, state: StateT, values: NDArray[np.float64]) -> StateT:
        """Return the state that has learnt the values, shape (k,), at the positions asked for.

        Raises:
            RuntimeError: no positions have been asked for since the last call.
            ValueError: there is not one value per position.
        """
        ...

    def best(self, state: StateT) -> tuple[NDArray[np.float64], float]:
        """Return the best position so far, shape (dim,), and its value."""
        ...
