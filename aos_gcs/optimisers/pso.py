"""PSO: particle swarm optimisation with one global best.

Source: Kennedy and Eberhart (1995), inertia by Shi and Eberhart (1998), as in the AOS-APSO paper, section Particle
Swarm Optimization (``eq:pso-update-a``, ``eq:pso-update-b``).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.optimisers.model import Particles, Schedule, remembered, start_particles
from aos_gcs.optimisers.randomness import Draw, Randomness, attraction, draw


@dataclass(frozen=True, slots=True, kw_only=True)
class PsoParameters:
    """Parameters of PSO; the defaults are the original ones."""

    c_c: float = 2.0
    """Cognitive factor, towards the personal best."""
    c_s: float = 2.0
    """Social factor, towards the global best."""
    inertia: Schedule = field(default_factory=lambda: Schedule(1.0))
    """omega, constant or linearly decreasing."""
    max_velocity: Schedule | None = None
    """Limit of the velocity, which may shrink; None for no limit."""
    randomness: Randomness = Randomness.VECTOR
    exponent: int = 3
    """m of the spherical randomness."""

    def __post_init__(self) -> None:
        for name, value in (("c_c", self.c_c), ("c_s", self.c_s)):
            if not (np.isfinite(value) and value >= 0.0):
                raise ConfigurationError(f"{name} must be a finite number of at least 0, but is {value:g}.")
        if self.exponent < 1:
            raise ConfigurationError(f"exponent must be a positive integer, but is {self.exponent}.")


@dataclass(frozen=True, slots=True)
class Pso:
    """Particle swarm optimisation."""

    parameters: PsoParameters = field(default_factory=PsoParameters)

    def init(self, positions: NDArray[np.float64], velocities: NDArray[np.float64] | None = None) -> Particles:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.init`."""
        return start_particles(positions, velocities)

    def ask(self, state: Particles, rng: np.random.Generator) -> tuple[NDArray[np.float64], Particles]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.ask`."""
        check_told(state)
        if state.told:
            state = moved(state, attracted_velocities(state, self.parameters, rng), self.parameters)
        return state.positions.copy(), replace(state, awaits_tell=True)

    def tell(self, state: Particles, values: NDArray[np.float64]) -> Particles:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.tell`."""
        return remembered(state, values)

    def best(self, state: Particles) -> tuple[NDArray[np.float64], float]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.best`."""
        return state.best_position, state.best_value


def check_told(particles: Particles) -> None:
    """Check that the values of the latest positions are known.

    Raises:
        RuntimeError: they are not.
    """
    if particles.awaits_tell:
        raise RuntimeError("ask() needs the values of the latest positions first: call tell() after each ask()")


def attracted_velocities(
    particles: Particles, parameters: PsoParameters, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the next velocities, shape (n, dim), before any limit."""
    n, dim = particles.positions.shape
    cognitive, social = (draw(parameters.randomness, n, dim, rng) for _ in range(2))
    return drawn_velocities(particles, parameters, cognitive, social)


def drawn_velocities(
    particles: Particles, parameters: PsoParameters, cognitive: Draw, social: Draw
) -> NDArray[np.float64]:
    """Return the next velocities, shape (n, dim), for given random numbers (``eq:pso-update-a``)."""
    x = particles.positions
    to_personal_best = attraction(particles.best_positions - x, cognitive, parameters.exponent)
    to_global_best = attraction(particles.best_position - x, social, parameters.exponent)
    return (
        parameters.inertia.at(particles.moves) * particles.velocities
        + parameters.c_c * to_personal_best
        + parameters.c_s * to_global_best
    )


def moved(particles: Particles, velocities: NDArray[np.float64], parameters: PsoParameters) -> Particles:
    """Return the particles after a step with these velocities, limited (``eq:pso-update-b``).

    The limit holds per dimension for the vector's randomness, as is usual, and for the length of the velocity
    otherwise, so that a search that is invariant to rotation stays so.
    """
    if parameters.max_velocity is not None:
        limit = parameters.max_velocity.at(particles.moves)
        if parameters.randomness is Randomness.VECTOR:
            velocities = np.clip(velocities, -limit, limit)
        else:
            lengths = np.linalg.norm(velocities, axis=1, keepdims=True)
            velocities = velocities * (limit / np.maximum(lengths, limit))
    return replace(
        particles, positions=particles.positions + velocities, velocities=velocities, moves=particles.moves + 1
    )
