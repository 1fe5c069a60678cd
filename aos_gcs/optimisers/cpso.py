"""CPSO: particle swarm optimisation whose particles repel each other, for objectives that change.

Source: Blackwell and Bentley (2002), as in the AOS-APSO paper, section Charged PSO (``eq:cpso``). A caller that
knows that the objective has changed makes the swarm :func:`~aos_gcs.optimisers.model.forgetful`, for remembered values
are then wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.optimisers.model import Particles, remembered, start_particles
from aos_gcs.optimisers.pso import PsoParameters, attracted_velocities, check_told, moved


@dataclass(frozen=True, slots=True)
class Cpso:
    """Charged particle swarm optimisation."""

    charges: tuple[float, ...]
    """Q_i of each particle; 0 for a neutral one."""
    max_distance: float
    """d_max: particles farther apart do not repel each other."""
    parameters: PsoParameters = field(default_factory=PsoParameters)

    def __post_init__(self) -> None:
        if not self.max_distance > 0.0:
            raise ConfigurationError(f"max_distance must be above 0, but is {self.max_distance:g}.")
        if not all(np.isfinite(charge) and charge >= 0.0 for charge in self.charges):
            raise ConfigurationError(f"charges must be finite and at least 0, but are {self.charges}.")

    def init(self, positions: NDArray[np.float64], velocities: NDArray[np.float64] | None = None) -> Particles:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.init`; there must be one charge per particle."""
        if len(positions) != len(self.charges):
            raise ValueError(f"{len(positions)} particles need as many charges, but there are {len(self.charges)}")
        return start_particles(positions, velocities)

    def ask(self, state: Particles, rng: np.random.Generator) -> tuple[NDArray[np.float64], Particles]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.ask`."""
        check_told(state)
        if state.told:
            attracted = attracted_velocities(state, self.parameters, rng)
            repelled = repulsion(state.positions, np.array(self.charges), self.max_distance)
            state = moved(state, attracted + repelled, self.parameters)
        return state.positions.copy(), replace(state, awaits_tell=True)

    def tell(self, state: Particles, values: NDArray[np.float64]) -> Particles:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.tell`."""
        return remembered(state, values)

    def best(self, state: Particles) -> tuple[NDArray[np.float64], float]:
        """See :meth:`aos_gcs.optimisers.model.Optimiser.best`."""
        return state.best_position, state.best_value


def repulsion(positions: NDArray[np.float64], charges: NDArray[np.float64], max_distance: float) -> NDArray[np.float64]:
    """Return the term that repulsion adds to the velocities, shape (n, dim) (``eq:cpso``).

    Args:
        positions: shape (n, dim).
        charges: shape (n,).
        max_distance: pairs at this distance or beyond, and coincident ones, do not repel each other.
    """
    d = positions[:, None] - positions[None, :]
    distances = np.linalg.norm(d, axis=2)
    near = (distances > 0.0) & (distances < max_distance)
    strengths = np.divide(np.outer(charges, charges), distances**3, out=np.zeros_like(distances), where=near)
    force: NDArray[np.float64] = (strengths[..., None] * d).sum(axis=1)
    return force
