"""Blind sampling: what a swarm that reacts has to beat.

Source: the baselines of Nathan, Kurmi and Bimber, Communications Engineering 2:55 (2023).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm import motion
from aos_gcs.swarm.line import line_axis
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.parameters import LineParameters, SequentialParameters, parse_parameters
from aos_gcs.swarm.state import Point, SwarmState

PARALLEL_NAME = "blind-parallel"
SEQUENTIAL_NAME = "blind-sequential"


@dataclass(frozen=True, slots=True)
class ParallelSampling:
    """A line of drones that scans on and never reacts to what it sees."""

    parameters: LineParameters

    @property
    def name(self) -> str:
        """The name in the registry."""
        return PARALLEL_NAME

    @property
    def spacing_m(self) -> float:
        """See :attr:`aos_gcs.swarm.model.Strategy.spacing_m`."""
        return self.parameters.c4_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.init`."""
        return motion.initial_state(scan_direction_enu)

    def tell(self, state: SwarmState, observation: Observation) -> SwarmState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`."""
        return _taken_in_blindly(state, observation)

    def ask(
        self,
        state: SwarmState,
        rng: np.random.Generator,  # noqa: ARG002 - nothing is random
    ) -> tuple[NDArray[np.float64], SwarmState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        positions_m, order, _ = motion.sorted_positions(motion.check_told(state))
        scan_direction = np.array(state.scan_direction_enu)
        moved_m = motion.line_move(positions_m, scan_direction, self.parameters.c3_m, self.parameters)
        return motion.in_told_order(moved_m, order), replace(state, awaits_ask=False)

    def diagnostics(self, state: SwarmState) -> Diagnostics:  # noqa: ARG002 - always the same
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        return Diagnostics(branch="line")


@dataclass(frozen=True, slots=True)
class SequentialState:
    """Progress of the only drone that samples."""

    swarm: SwarmState
    start_enu_m: Point | None = None
    """First known position of that drone: the middle of the first row; None before."""
    flown: int = 0
    """Waypoints given out so far."""


@dataclass(frozen=True, slots=True)
class SequentialSampling:
    """One drone, the one with the lowest id, that flies over a grid row by row; all others stay where they are."""

    parameters: SequentialParameters

    @property
    def name(self) -> str:
        """The name in the registry."""
        return SEQUENTIAL_NAME

    @property
    def spacing_m(self) -> float:
        """See :attr:`aos_gcs.swarm.model.Strategy.spacing_m`."""
        return self.parameters.c4_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> SequentialState:
        """See :meth:`aos_gcs.swarm.model.Strategy.init`."""
        return SequentialState(motion.initial_state(scan_direction_enu))

    def tell(self, state: SequentialState, observation: Observation) -> SequentialState:
        """See :meth:`aos_gcs.swarm.model.Strategy.tell`; one vehicle is enough."""
        swarm = _taken_in_blindly(state.swarm, observation, min_vehicles=1)
        start_enu_m = state.start_enu_m
        if start_enu_m is None and swarm.situation is not None:
            flyer = int(np.argmin(observation.vehicle_ids))
            start_enu_m = swarm.situation.positions_enu_m[flyer]
        return replace(state, swarm=swarm, start_enu_m=start_enu_m)

    def ask(
        self,
        state: SequentialState,
        rng: np.random.Generator,  # noqa: ARG002 - nothing is random
    ) -> tuple[NDArray[np.float64], SequentialState]:
        """See :meth:`aos_gcs.swarm.model.Strategy.ask`."""
        situation = motion.check_told(state.swarm)
        positions_m = np.array(situation.positions_enu_m)
        east, north = grid_place(state.flown, self.parameters.width_m, self.parameters.c4_m)
        axis, scan_direction = line_axis(np.array(state.swarm.scan_direction_enu)), state.swarm.scan_direction_enu
        flyer = int(np.argmin(situation.vehicle_ids))
        positions_m[flyer] = np.array(state.start_enu_m) + east * axis + north * np.array(scan_direction)
        asked = replace(state.swarm, awaits_ask=False)
        return positions_m, replace(state, swarm=asked, flown=state.flown + 1)

    def diagnostics(self, state: SequentialState) -> Diagnostics:  # noqa: ARG002 - always the same
        """See :meth:`aos_gcs.swarm.model.Strategy.diagnostics`."""
        return Diagnostics(branch="grid")


def grid_place(index: int, width_m: float, spacing_m: float) -> Point:
    """Return a place of the grid, metres across and along the scanning direction, in the order of the flight.

    Rows of the given width are centred on the start and flown to and fro; a width below the spacing leaves one place
    per row, a straight line of waypoints.
    """
    per_row = int(width_m / spacing_m + 1e-9) + 1
    row, column = divmod(index, per_row)
    if row % 2 == 1:
        column = per_row - 1 - column
    return (spacing_m * (column - (per_row - 1) / 2.0), spacing_m * row)


def make_parallel(parameters: Mapping[str, object]) -> ParallelSampling:
    """Return parallel blind sampling with the parameters given (:class:`LineParameters`).

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return ParallelSampling(parse_parameters(LineParameters, parameters, PARALLEL_NAME))


def make_sequential(parameters: Mapping[str, object]) -> SequentialSampling:
    """Return sequential blind sampling with the parameters given (:class:`SequentialParameters`).

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return SequentialSampling(parse_parameters(SequentialParameters, parameters, SEQUENTIAL_NAME))


def _taken_in_blindly(state: SwarmState, observation: Observation, min_vehicles: int = 2) -> SwarmState:
    """Return the state that knows where the vehicles are and nothing of what they see."""
    motion.check_observation(observation, min_vehicles)
    unseen = replace(observation, target_in_view=False, target_enu_m=None, leader_id=None)
    return motion.take_in(state, unseen, min_vehicles)
