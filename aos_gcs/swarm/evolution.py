"""The evolutionary states and the factors of AOS-APSO.

Source: AOS-APSO paper, section Adjustments to APSO. The evolutionary factor, the order of the states and the
directions in which the factors move are those of APSO (:mod:`aos_gcs.optimisers.evolution`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_gcs.optimisers.evolution import DIRECTIONS, EvolutionaryState, kept_in_sequence

OPEN_MARGIN = 1e-12
"""Keeps the interval (0, 1) open against rounding."""

_EXPLORATION, _EXPLOITATION, _CONVERGENCE, _JUMPING_OUT = EvolutionaryState

STATE_TABLE = (
    (0.025, (_CONVERGENCE,)),
    (0.1, (_EXPLOITATION, _CONVERGENCE)),
    (0.15, (_EXPLOITATION,)),
    (0.25, (_EXPLORATION, _EXPLOITATION)),
    (0.5, (_EXPLORATION,)),
    (0.6, (_JUMPING_OUT, _EXPLORATION)),
    (math.inf, (_JUMPING_OUT,)),
)
"""Upper end of e_f, excluded, and the states that apply below it (``tab:map-ef-to-state``)."""


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


def next_state(e_f: float, previous: EvolutionaryState) -> EvolutionaryState:
    """Return the state for an evolutionary factor; where two apply, the previous state decides.

    The table's conditions on the previous state are all one rule: the sequence of the states is kept.
    """
    applying = next(states for end, states in STATE_TABLE if e_f < end)
    return applying[0] if len(applying) == 1 else kept_in_sequence(*applying, previous)


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
    cognitive, social = DIRECTIONS[state]
    c_s_hat, c_c_hat = _moved(factors.c_s_hat, social, gamma), _moved(factors.c_c_hat, cognitive, gamma)
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


def _moved(factor: float, direction: float, gamma: float) -> float:
    """Return the factor moved up or down, by |direction| of the full change."""
    slowed = 1.0 - abs(direction) * (1.0 - gamma)
    return increase(factor, slowed) if direction > 0.0 else decrease(factor, slowed)
