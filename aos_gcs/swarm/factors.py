"""Rules for the social and the cognitive factor: fixed, tuned, or as in APSO.

Source: AOS-APSO paper, sections AOS-PSO and Modified parameter adaption.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from aos_gcs.optimisers.evolution import (
    MAX_SUM,
    START_FACTOR,
    EvolutionaryState,
    adapted_factors,
    draw_delta,
    fuzzy_state,
)
from aos_gcs.swarm.evolution import FractionalFactors, adapt, next_state
from aos_gcs.swarm.parameters import AosApsoPaperParameters
from aos_gcs.swarm.state import Adaptation


class FactorRule(Protocol):
    """The part in which the strategies that follow a leader differ."""

    def start(self) -> Adaptation:
        """Return the factors of a search that starts: also whenever the target is lost."""
        ...

    def adapted(self, before: Adaptation, e_f: float, rng: np.random.Generator) -> Adaptation:
        """Return the factors for a step with this evolutionary factor."""
        ...

    def in_metres(self, adaptation: Adaptation) -> tuple[float, float]:
        """Return c_s and c_c, metres."""
        ...


@dataclass(frozen=True, slots=True)
class FixedFactors:
    """AOS-PSO's: what they are they stay."""

    c_s_m: float
    c_c_m: float

    def start(self) -> Adaptation:
        """See :meth:`FactorRule.start`."""
        return Adaptation(social=self.c_s_m, cognitive=self.c_c_m)

    def adapted(self, before: Adaptation, e_f: float, rng: np.random.Generator) -> Adaptation:  # noqa: ARG002 - nothing adapts
        """See :meth:`FactorRule.adapted`."""
        return Adaptation(before.social, before.cognitive, e_f=e_f)

    def in_metres(self, adaptation: Adaptation) -> tuple[float, float]:
        """See :meth:`FactorRule.in_metres`."""
        return adaptation.social, adaptation.cognitive


@dataclass(frozen=True, slots=True)
class FractionalRule:
    """AOS-APSO's: fractions of c4 and of each other, which keep c_s > c_c and c_s + c_c <= c4 by themselves."""

    c4_m: float
    initial: FractionalFactors
    gamma: float
    min_factor: float
    max_factor: float

    def start(self) -> Adaptation:
        """Return the initial fractions (``eq:aso-apso-reset``).

        The paper names no initial state; like APSO's, a search starts in exploration.
        """
        return Adaptation(self.initial.c_s_hat, self.initial.c_c_hat, EvolutionaryState.EXPLORATION)

    def adapted(self, before: Adaptation, e_f: float, rng: np.random.Generator) -> Adaptation:  # noqa: ARG002 - nothing adapts
        """See :meth:`FactorRule.adapted`."""
        state = next_state(e_f, before.state or EvolutionaryState.EXPLORATION)
        factors = FractionalFactors(before.social, before.cognitive)
        factors = adapt(factors, state, self.gamma, self.min_factor, self.max_factor)
        return Adaptation(factors.c_s_hat, factors.c_c_hat, state, e_f)

    def in_metres(self, adaptation: Adaptation) -> tuple[float, float]:
        """See :meth:`FactorRule.in_metres`."""
        factors = FractionalFactors(adaptation.social, adaptation.cognitive)
        return factors.c_s_m(self.c4_m), factors.c_c_m(self.c4_m)


def fractional_rule(parameters: AosApsoPaperParameters) -> FractionalRule:
    """Return the paper's rule with these parameters."""
    initial = FractionalFactors(parameters.initial_c_s_hat, parameters.initial_c_c_hat)
    return FractionalRule(parameters.c4_m, initial, parameters.gamma, parameters.min_factor, parameters.max_factor)


@dataclass(frozen=True, slots=True)
class ApsoRule:
    """APSO's own, in metres: from 1.5 to 2.5, with a sum of 4 at most, or c4 where that is less.

    Nothing keeps c_s above c_c here: that is what the fractions of AOS-APSO are for.
    """

    c4_m: float

    def start(self) -> Adaptation:
        """See :meth:`FactorRule.start`."""
        factor_m = min(START_FACTOR, self._max_sum_m / 2.0)
        return Adaptation(factor_m, factor_m, EvolutionaryState.EXPLORATION)

    def adapted(self, before: Adaptation, e_f: float, rng: np.random.Generator) -> Adaptation:
        """See :meth:`FactorRule.adapted`."""
        state = fuzzy_state(e_f, before.state or EvolutionaryState.EXPLORATION)
        c_c_m, c_s_m = adapted_factors(before.cognitive, before.social, state, draw_delta(rng), self._max_sum_m)
        return Adaptation(c_s_m, c_c_m, state, e_f)

    def in_metres(self, adaptation: Adaptation) -> tuple[float, float]:
        """See :meth:`FactorRule.in_metres`."""
        return adaptation.social, adaptation.cognitive

    @property
    def _max_sum_m(self) -> float:
        return min(MAX_SUM, self.c4_m)
