"""AOS-APSO: AOS-PSO whose factors follow the state of the search.

Source: AOS-APSO paper, section Adaptive PSO strategy for AOS drone swarms; algorithms.md section 3e.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm import motion
from aos_gcs.swarm.evolution import EvolutionaryState, FractionalFactors, adapt, next_state
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.parameters import AosApsoParameters, parse_parameters
from aos_gcs.swarm.state import Adaptation, SwarmState

NAME = "aos-apso"


@dataclass(frozen=True, slots=True)
class AosApso:
    """Scans in line until the target is in view, then follows the leader with factors that adapt at each step."""

    parameters: AosApsoParameters

    @property
    def name(self) -> str:
        """The name in the registry."""
        return NAME

    @property
    def spacing_m(self) -> float:
        """See :attr:`aos_gcs.swarm.model.Strategy.spacing_m`."""
        return self.parameters.c4_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.init`."""
        return replace(motion.initial_state(scan_direction_enu), adaptation=self._reset())

    def tell(self, state: SwarmState, observation: Observation) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`."""
        state = motion.take_in(state, observation)
        return replace(state, adaptation=self._adapted(state))

    def ask(self, state: SwarmState, rng: np.random.Generator) -> tuple[NDArray[np.float64], SwarmState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        positions_m = motion.next_positions(state, self.parameters, *self._factors_m(state), rng)
        return positions_m, replace(state, awaits_ask=False)

    def diagnostics(self, state: SwarmState) -> Diagnostics:
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        leader_id = state.situation.leader_id if state.situation is not None else None
        adaptation = self._adaptation(state)
        c_s_m, c_c_m = self._factors_m(state)
        return Diagnostics(
            branch="line" if leader_id is None else "pso",
            evolutionary_factor=adaptation.e_f,
            evolutionary_state=str(adaptation.state) if adaptation.e_f is not None else None,
            c_s_m=c_s_m,
            c_c_m=c_c_m,
            leader_id=leader_id,
        )

    def _adapted(self, state: SwarmState) -> Adaptation:
        """Return the adaptation for the situation at hand: a reset in the default branch, else one step of it."""
        e_f = motion.observed_evolutionary_factor(state)
        if e_f is None:
            return self._reset()
        before = self._adaptation(state)
        evolutionary_state = next_state(e_f, before.state)
        factors = adapt(
            before.factors,
            evolutionary_state,
            self.parameters.gamma,
            self.parameters.min_factor,
            self.parameters.max_factor,
        )
        return Adaptation(factors, evolutionary_state, e_f)

    def _reset(self) -> Adaptation:
        """Return the initial adaptation (``eq:aso-apso-reset``).

        The paper names no initial state; like APSO's, a search starts in exploration.
        """
        factors = FractionalFactors(self.parameters.initial_c_s_hat, self.parameters.initial_c_c_hat)
        return Adaptation(factors, EvolutionaryState.EXPLORATION, e_f=None)

    def _adaptation(self, state: SwarmState) -> Adaptation:
        if state.adaptation is None:
            raise ValueError("this state is not one of AOS-APSO: it has no adaptation")
        return state.adaptation

    def _factors_m(self, state: SwarmState) -> tuple[float, float]:
        factors = self._adaptation(state).factors
        return factors.c_s_m(self.parameters.c4_m), factors.c_c_m(self.parameters.c4_m)


def make_aos_apso(parameters: Mapping[str, object]) -> AosApso:
    """Return AOS-APSO with the parameters given (:class:`AosApsoParameters`) and defaults for the rest.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return AosApso(parse_parameters(AosApsoParameters, parameters, NAME))
