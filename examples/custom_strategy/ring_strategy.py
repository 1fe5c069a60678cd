"""A strategy of one's own: scan in line until the target is in view, then stand in a ring around it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from aos_gcs.swarm import motion
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.parameters import LineParameters, parse_parameters
from aos_gcs.swarm.state import SwarmState


@dataclass(frozen=True)
class Ring:
    """Every drone looks at the target from another side; places are given so that the ways are short."""

    parameters: LineParameters
    spacing_m: float
    name: str = "ring"

    def init(self, scan_direction_enu: NDArray[np.float64]) -> SwarmState:
        return motion.initial_state(scan_direction_enu)

    def tell(self, state: SwarmState, observation: Observation) -> SwarmState:
        return motion.take_in(state, observation)

    def ask(self, state: SwarmState, rng: np.random.Generator) -> tuple[NDArray[np.float64], SwarmState]:
        positions_m, order, _ = motion.sorted_positions(motion.check_told(state))
        if state.track is None or not state.track.in_view:
            scan_direction = np.array(state.scan_direction_enu)
            moved_m = motion.line_move(positions_m, scan_direction, self.parameters.c3_m, self.parameters)
        else:
            angles_rad = np.arange(len(positions_m)) * 2.0 * np.pi / len(positions_m) + rng.uniform(0.0, 0.3)
            radius_m = self.spacing_m / (2.0 * np.sin(np.pi / len(positions_m)))
            ring_m = state.track.last_enu_m + radius_m * np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
            squared_ways = ((positions_m[:, None] - ring_m[None, :]) ** 2).sum(axis=2)
            moved_m = ring_m[linear_sum_assignment(squared_ways)[1]]
        return motion.in_told_order(moved_m, order), replace(state, awaits_ask=False)

    def diagnostics(self, state: SwarmState) -> Diagnostics:
        return Diagnostics(branch="line" if state.track is None or not state.track.in_view else "ring")


def make_ring(parameters: Mapping[str, object]) -> Ring:
    chosen = parse_parameters(LineParameters, parameters, "ring")
    return Ring(chosen, chosen.c4_m)
