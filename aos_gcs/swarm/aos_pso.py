"""AOS-PSO: a drone swarm that samples around the drone with the best view.

Source: Nathan, Kurmi and Bimber, Communications Engineering 2:55 (2023), as in the AOS-APSO paper
(``alg:pso-for-aos``); algorithms.md section 3c.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm import motion
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.parameters import AosPsoParameters, parse_parameters
from aos_gcs.swarm.state import SwarmState

NAME = "aos-pso"


@dataclass(frozen=True, slots=True)
class AosPso:
    """Scans in line until the target is in view, then follows the leader with fixed factors."""

    parameters: AosPsoParameters

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
        return motion.initial_state(scan_direction_enu)

    def tell(self, state: SwarmState, observation: Observation) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`."""
        return motion.take_in(state, observation)

    def ask(self, state: SwarmState, rng: np.random.Generator) -> tuple[NDArray[np.float64], SwarmState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        factors_m = self.parameters.c_s_m, self.parameters.c_c_m
        positions_m = motion.next_positions(state, self.parameters, *factors_m, rng)
        return positions_m, replace(state, awaits_ask=False)

    def diagnostics(self, state: SwarmState) -> Diagnostics:
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        leader_id = state.situation.leader_id if state.situation is not None else None
        return Diagnostics(
            branch="line" if leader_id is None else "pso",
            evolutionary_factor=motion.observed_evolutionary_factor(state),
            c_s_m=self.parameters.c_s_m,
            c_c_m=self.parameters.c_c_m,
            leader_id=leader_id,
        )


def make_aos_pso(parameters: Mapping[str, object]) -> AosPso:
    """Return AOS-PSO with the parameters given (:class:`AosPsoParameters`) and defaults for the rest.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return AosPso(parse_parameters(AosPsoParameters, parameters, NAME))
