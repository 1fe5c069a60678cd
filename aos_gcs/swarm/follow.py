"""Strategies that scan in line until the target is in view, then gather around the drone that sees most of it.

AOS-PSO and AOS-APSO are this strategy with different factors and switches (:mod:`aos_gcs.swarm.aos_pso`,
:mod:`aos_gcs.swarm.aos_apso`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm import motion
from aos_gcs.swarm.factors import FactorRule
from aos_gcs.swarm.memory import remember
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.parameters import SwarmParameters
from aos_gcs.swarm.state import Adaptation, SwarmState


@dataclass(frozen=True, slots=True)
class LeaderFollowing:
    """The algorithm PSO update for AOS drone swarms (``alg:pso-for-aos``)."""

    name: str
    """The name in the registry."""
    parameters: SwarmParameters
    rule: FactorRule

    @property
    def spacing_m(self) -> float:
        """See :attr:`aos_gcs.swarm.model.Strategy.spacing_m`."""
        return self.parameters.c4_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.init`."""
        return replace(motion.initial_state(scan_direction_enu), adaptation=self.rule.start())

    def tell(self, state: SwarmState, observation: Observation) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`."""
        return remember(motion.take_in(state, observation), observation, self.parameters)

    def ask(self, state: SwarmState, rng: np.random.Generator) -> tuple[NDArray[np.float64], SwarmState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        motion.check_told(state)
        e_f = motion.observed_evolutionary_factor(state)
        adaptation = self.rule.start() if e_f is None else self.rule.adapted(self._adaptation(state), e_f, rng)
        c_s_m, c_c_m = self.rule.in_metres(adaptation)
        positions_m = motion.next_positions(state, self.parameters, c_s_m, c_c_m, rng)
        return positions_m, replace(state, adaptation=adaptation, awaits_ask=False)

    def diagnostics(self, state: SwarmState) -> Diagnostics:
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        leader_id = state.situation.leader_id if state.situation is not None else None
        adaptation = self._adaptation(state)
        c_s_m, c_c_m = self.rule.in_metres(adaptation)
        return Diagnostics(
            branch="line" if leader_id is None else "pso",
            evolutionary_factor=adaptation.e_f,
            evolutionary_state=str(adaptation.state) if adaptation.state and adaptation.e_f is not None else None,
            c_s_m=c_s_m,
            c_c_m=c_c_m,
            leader_id=leader_id,
        )

    def _adaptation(self, state: SwarmState) -> Adaptation:
        if state.adaptation is None:
            raise ValueError(f"this state is not one of {self.name}: it has no factors")
        return state.adaptation
