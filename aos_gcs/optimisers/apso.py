"""APSO: particle swarm optimisation that adapts its factors and inertia to the state of the search.

Source: Zhan, Zhang, Li and Chung, *Adaptive particle swarm optimization*, IEEE TSMC-B 39(6), 2009 [Z], as in the
AOS-APSO paper, section Adaptive PSO.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.optimisers.evolution import (
    START_FACTOR,
    EvolutionaryState,
    adapted_factors,
    draw_delta,
    evolutionary_factor,
    fuzzy_state,
    inertia_weight,
)
from aos_gcs.optimisers.model import Particles, Schedule, remembered, start_particles
from aos_gcs.optimisers.pso import PsoParameters, attracted_velocities, check_told, moved
from aos_gcs.optimisers.randomness import Randomness

MAX_VELOCITY_SHARE = 0.2
"""Limit of the velocity as a share of the search range [Z]."""


@dataclass(frozen=True, slots=True, eq=False)
class ApsoState:
    """The particles and what APSO knows of their search."""

    particles: Particles
    c_c: float = START_FACTOR
    c_s: float = START_FACTOR
    evolutionary_state: EvolutionaryState = EvolutionaryState.EXPLORATION
    e_f: float | None = None
    """Evolutionary factor before the latest move; None before the first."""
    elite: NDArray[np.float64] | None = None
    """Perturbed global best whose value is awaited, shape (dim,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Apso:
    """Adaptive particle swarm optimisation.

    In convergence ``ask`` returns a row more than there are particles: the elitist perturbation of the global best.
    """

    lower: float
    """Lower end of the search range, alike in all dimensions."""
    upper: float
    """Upper end of the search range."""
    moves: int
    """Number of moves over which the elitist perturbation shrinks."""
    randomness: Randomness = Randomness.VECTOR
    sigma: tuple[float, float] = (1.0, 0.1)
    """Standard deviation of the perturbation at the start and at the end, as a share of the range."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.lower) and np.isfinite(self.upper) and self.lower < self.upper):
            raise ConfigurationError(f"lower must be below upper, but they are {self.lower:g} and {self.upper:g}.")
        if self.moves < 1:
            raise ConfigurationError(f"moves must be at least 1, but is {self.moves}.")

    def init(self, positions: NDArray[np.float64], velocities: NDArray[np.float64] | None = None) -> ApsoState:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.init`."""
        return ApsoState(start_particles(positions, velocities))

    def ask(self, state: ApsoState, rng: np.random.Generator) -> tuple[NDArray[np.float64], ApsoState]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.ask`."""
        check_told(state.particles)
        if state.particles.told:
            state = self._moved(self._adapted(state, rng), rng)
        particles = replace(state.particles, awaits_tell=True)
        asked = particles.positions.copy() if state.elite is None else np.vstack([particles.positions, state.elite])
        return asked, replace(state, particles=particles)

    def tell(self, state: ApsoState, values: NDArray[np.float64]) -> ApsoState:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.tell`."""
        if state.elite is None:
            return replace(state, particles=remembered(state.particles, values))
        count = len(state.particles.positions)
        if np.shape(values) != (count + 1,):
            raise ValueError(f"values need shape ({count + 1},), but have {np.shape(values)}")
        particles = remembered(state.particles, values[:count])
        return replace(state, particles=_with_elite(particles, values[:count], state.elite, values[count]), elite=None)

    def best(self, state: ApsoState) -> tuple[NDArray[np.float64], float]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.best`."""
        return state.particles.best_position, state.particles.best_value

    def _adapted(self, state: ApsoState, rng: np.random.Generator) -> ApsoState:
        """Return the state with factors that fit the present spread of the particles."""
        e_f = evolutionary_factor(state.particles.positions, state.particles.leader)
        evolutionary_state = fuzzy_state(e_f, state.evolutionary_state)
        c_c, c_s = adapted_factors(state.c_c, state.c_s, evolutionary_state, draw_delta(rng))
        return replace(state, c_c=c_c, c_s=c_s, evolutionary_state=evolutionary_state, e_f=e_f)

    def _moved(self, state: ApsoState, rng: np.random.Generator) -> ApsoState:
        parameters = PsoParameters(
            c_c=state.c_c,
            c_s=state.c_s,
            inertia=Schedule(inertia_weight(state.e_f or 0.0)),
            max_velocity=Schedule(MAX_VELOCITY_SHARE * (self.upper - self.lower)),
            randomness=self.randomness,
        )
        particles = moved(state.particles, attracted_velocities(state.particles, parameters, rng), parameters)
        converging = state.evolutionary_state is EvolutionaryState.CONVERGENCE
        return replace(state, particles=particles, elite=self._elite(particles, rng) if converging else None)

    def _elite(self, particles: Particles, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the global best, perturbed in one dimension and kept in the range (elitist learning)."""
        elite = particles.best_position.copy()
        dimension = rng.integers(len(elite))
        sigma = Schedule(*self.sigma, steps=self.moves).at(particles.moves)
        elite[dimension] += (self.upper - self.lower) * rng.normal(scale=sigma)
        elite[dimension] = np.clip(elite[dimension], self.lower, self.upper)
        return elite


def _with_elite(
    particles: Particles, values: NDArray[np.float64], elite: NDArray[np.float64], elite_value: float
) -> Particles:
    """Return the particles after elitist learning: a better elite is the global best, another replaces the worst."""
    if elite_value < particles.best_value:
        best_positions, best_values = particles.best_positions.copy(), particles.best_values.copy()
        best_positions[particles.leader], best_values[particles.leader] = elite, elite_value
        return replace(particles, best_positions=best_positions, best_values=best_values)
    positions = particles.positions.copy()
    positions[np.where(np.isnan(values), np.inf, values).argmax()] = elite
    return replace(particles, positions=positions)
