"""APSO's view of a search: the evolutionary factor, the four states, and how the factors follow them.

Source: Zhan, Zhang, Li and Chung, *Adaptive particle swarm optimization*, IEEE TSMC-B 39(6), 2009 [Z], as in the
AOS-APSO paper, section Adaptive PSO.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class EvolutionaryState(StrEnum):
    """The four states of a search, in the order in which they are meant to follow each other, round and round."""

    EXPLORATION = "exploration"
    EXPLOITATION = "exploitation"
    CONVERGENCE = "convergence"
    JUMPING_OUT = "jumping_out"


SEQUENCE = tuple(EvolutionaryState)

DIRECTIONS = {
    EvolutionaryState.EXPLORATION: (1.0, -1.0),
    EvolutionaryState.EXPLOITATION: (0.5, -0.5),
    EvolutionaryState.CONVERGENCE: (0.5, 0.5),
    EvolutionaryState.JUMPING_OUT: (-1.0, 1.0),
}
"""State to the change of (c_c, c_s): up or down, by a half where it is 'slightly'."""

MIN_FACTOR, MAX_FACTOR, MAX_SUM = 1.5, 2.5, 4.0
"""Limits of c_c and c_s, and of their sum [Z]."""

START_FACTOR = 2.0
"""c_c and c_s at the start [Z]."""


def evolutionary_factor(positions: NDArray[np.float64], leader: int) -> float:
    """Return e_f in [0, 1]: 0 for the most central leader, 1 for the most remote one (``eq:aspo-ef``).

    Where all particles are equally central, as two always are, no leader can be off the centre: 0.

    Args:
        positions: shape (n, dim), n >= 2.
        leader: row of the leader.
    """
    distances = np.linalg.norm(positions[:, None] - positions[None, :], axis=2)
    d = distances.sum(axis=1) / (len(positions) - 1)
    spread = float(d.max() - d.min())
    if spread <= 1e-9 * float(d.max()):
        return 0.0
    return float(d[leader] - d.min()) / spread


def memberships(e_f: float) -> dict[EvolutionaryState, float]:
    """Return how far each state applies at an evolutionary factor, 0 to 1 [Z]."""
    return {
        EvolutionaryState.EXPLORATION: float(np.interp(e_f, (0.4, 0.6, 0.7, 0.8), (0.0, 1.0, 1.0, 0.0))),
        EvolutionaryState.EXPLOITATION: float(np.interp(e_f, (0.2, 0.3, 0.4, 0.6), (0.0, 1.0, 1.0, 0.0))),
        EvolutionaryState.CONVERGENCE: float(np.interp(e_f, (0.1, 0.3), (1.0, 0.0))),
        EvolutionaryState.JUMPING_OUT: float(np.interp(e_f, (0.7, 0.9), (0.0, 1.0))),
    }


def fuzzy_state(e_f: float, previous: EvolutionaryState) -> EvolutionaryState:
    """Return APSO's state for an evolutionary factor; where two apply, the previous state decides."""
    applying = [state for state, membership in memberships(e_f).items() if membership > 0.0]
    if len(applying) == 1:
        return applying[0]
    return kept_in_sequence(applying[0], applying[1], previous)


def kept_in_sequence(
    one: EvolutionaryState, other: EvolutionaryState, previous: EvolutionaryState
) -> EvolutionaryState:
    """Return which of two neighbouring states follows ``previous`` so that the sequence of states is kept.

    The earlier of the two holds on while the search is in it or comes from the state before it; else it is the later.
    """
    earlier, later = (one, other) if _before(other) is one else (other, one)
    return earlier if previous in {earlier, _before(earlier)} else later


def adapted_factors(
    c_c: float, c_s: float, state: EvolutionaryState, delta: float, max_sum: float = MAX_SUM
) -> tuple[float, float]:
    """Return APSO's c_c and c_s after one step in ``state``, in [1.5, 2.5] unless their sum must be less.

    Args:
        c_c: cognitive factor before.
        c_s: social factor before.
        state: the present evolutionary state.
        delta: acceleration rate, drawn from [0.05, 0.1].
        max_sum: both are scaled alike where their sum is above it.
    """
    cognitive, social = DIRECTIONS[state]
    c_c, c_s = (
        min(max(factor + direction * delta, MIN_FACTOR), MAX_FACTOR)
        for factor, direction in ((c_c, cognitive), (c_s, social))
    )
    scale = min(1.0, max_sum / (c_c + c_s))
    return scale * c_c, scale * c_s


def draw_delta(rng: np.random.Generator) -> float:
    """Return an acceleration rate, uniform in [0.05, 0.1) [Z]."""
    return float(rng.uniform(0.05, 0.1))


def inertia_weight(e_f: float) -> float:
    """Return omega(e_f), from 0.4 to 0.9 (``eq:apso-w``)."""
    return 1.0 / (1.0 + 1.5 * math.exp(-2.6 * e_f))


def _before(state: EvolutionaryState) -> EvolutionaryState:
    return SEQUENCE[SEQUENCE.index(state) - 1]
