"""The evolutionary factor, state and factors of AOS-APSO.

Source: AOS-APSO paper, section Adjustments to APSO; algorithms.md section 3e. The directions in which the factors move
per state are those of APSO (Zhan et al., IEEE TSMC-B 39(6), 2009).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

OPEN_MARGIN = 1e-12
"""Keeps the interval (0, 1) open against rounding."""


class EvolutionaryState(StrEnum):
    """APSO's four states of a search."""

    EXPLORATION = "exploration"
    EXPLOITATION = "exploitation"
    CONVERGENCE = "convergence"
    JUMPING_OUT = "jumping_out"


@dataclass(frozen=True, slots=True)
class FractionalFactors:
    """The auxiliary variables of AOS-APSO, both in the open interval (0, 1)."""

    c_s_hat: float
    """Social factor as a fraction of c4."""
    c_c_hat: float
    """Cognitive factor as a fraction of the social one."""

    def c_s_m(self, c4_m: float) -> float:
        """Return the social factor, metres (``eq:aos-apso-soc-translation``)."""
        return c4_m * self.c_s_hat

    def c_c_m(self, c4_m: float) -> float:
        """Return the cognitive factor, metres (``eq:aos-apso-cog-translation``)."""
        return self.c_s_m(c4_m) * self.c_c_hat


def evolutionary_factor(positions_enu_m: NDArray[np.float64], leader: int) -> float:
    """Return e_f in [0, 1]: 0 for the most central leader, 1 for the most remote one (``eq:aspo-ef``).

    Where all drones are equally central, as two always are, no leader can be off the centre: 0.

    Args:
        positions_enu_m: shape (n, 2), n >= 2, metres.
        leader: row of the leader.
    """
    distances_m = np.linalg.norm(positions_enu_m[:, None] - positions_enu_m[None, :], axis=2)
    d = distances_m.sum(axis=1) / (len(positions_enu_m) - 1)
    spread_m = float(d.max() - d.min())
    if spread_m <= 1e-9 * float(d.max()):
        return 0.0
    return float(d[leader] - d.min()) / spread_m


def next_state(e_f: float, previous: EvolutionaryState) -> EvolutionaryState:  # noqa: PLR0911 - one line per table row
    """Return the state for an evolutionary factor (``tab:map-ef-to-state``)."""
    exploration, exploitation = EvolutionaryState.EXPLORATION, EvolutionaryState.EXPLOITATION
    convergence, jumping_out = EvolutionaryState.CONVERGENCE, EvolutionaryState.JUMPING_OUT
    if e_f < 0.025:
        return convergence
    if e_f < 0.1:
        return exploitation if previous in {exploitation, exploration} else convergence
    if e_f < 0.15:
        return exploitation
    if e_f < 0.25:
        return exploration if previous in {exploration, jumping_out} else exploitation
    if e_f < 0.5:
        return exploration
    if e_f < 0.6:
        return jumping_out if previous in {jumping_out, convergence} else exploration
    return jumping_out


def increase(factor: float, gamma: float) -> float:
    """Return the factor moved towards 1 (``eq:aos-apso-increase``)."""
    return 1.0 - gamma * (1.0 - factor)


def decrease(factor: float, gamma: float) -> float:
    """Return the factor moved towards 0 (``eq:aos-apso-decrease``)."""
    return gamma * factor


def adapt(
    factors: FractionalFactors,
    state: EvolutionaryState,
    gamma: float,
    minimum: float = 0.0,
    maximum: float = 1.0,
) -> FractionalFactors:
    """Return the factors after one step in ``state``, normalised so that c_s + c_c <= c4.

    Args:
        factors: before the step.
        state: the present evolutionary state.
        gamma: deceleration factor in (0, 1); 'slightly' is half of the change, (1 + gamma) / 2.
        minimum: lower bound of both factors; yields where the normalisation needs less.
        maximum: upper bound of both factors.
    """
    slightly = (1.0 + gamma) / 2.0
    match state:
        case EvolutionaryState.EXPLORATION:
            c_s_hat, c_c_hat = decrease(factors.c_s_hat, gamma), increase(factors.c_c_hat, gamma)
        case EvolutionaryState.EXPLOITATION:
            c_s_hat, c_c_hat = decrease(factors.c_s_hat, slightly), increase(factors.c_c_hat, slightly)
        case EvolutionaryState.CONVERGENCE:
            c_s_hat, c_c_hat = increase(factors.c_s_hat, slightly), increase(factors.c_c_hat, slightly)
        case EvolutionaryState.JUMPING_OUT:
            c_s_hat, c_c_hat = increase(factors.c_s_hat, gamma), decrease(factors.c_c_hat, gamma)
    low, high = max(minimum, OPEN_MARGIN), min(maximum, 1.0 - OPEN_MARGIN)
    return normalise(FractionalFactors(min(max(c_s_hat, low), high), min(max(c_c_hat, low), high)))


def normalise(factors: FractionalFactors) -> FractionalFactors:
    """Return the factors, both scaled by the one k that gives k c_s_hat (1 + k c_c_hat) = 1 where it was above 1.

    The paper asks for the normalisation without saying how; one common scale keeps the ratio that the adaptation has
    reached. The result satisfies ``eq:aos-pso-parameter-constraint-2``.
    """
    s, c = factors.c_s_hat, factors.c_c_hat
    if s * (1.0 + c) <= 1.0:
        return factors
    # The positive root of s c k^2 + s k - 1 = 0, in the form that does not cancel.
    k = 2.0 / (s + math.sqrt(s * s + 4.0 * s * c))
    return FractionalFactors(k * s, k * c)
