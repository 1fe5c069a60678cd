"""Close look of a single vehicle: it makes its aperture by visiting the places of a grid, one after the other.

The places are those of a hexagonal grid about the target, a swarm's spacing apart, from the middle outwards: the views
of so many vehicles, in as many steps. Strategies of swarms compare what vehicles see at the same time; one has no other
to compare with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.line import unit_vector
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.state import Point

RINGS: Final = 2
"""Rings about the middle: 6 and 12 places. From 35 m the outer ones still see the target well within the frame."""


@dataclass(frozen=True, slots=True)
class LoneState:
    """State of :class:`LoneLook`: plain data that can be saved and replayed."""

    scan_direction_enu: Point
    """Unit vector."""
    positions_enu_m: tuple[Point, ...] = ()
    """Places by the latest observation; none once the next ones have been asked for."""
    target_enu_m: Point | None = None
    """Target seen last; None: nothing was in view since the line was formed."""
    visited: int = 0
    """Number of places about the target that were flown to."""


class LoneLook:
    """Implements :class:`~aos_gcs.swarm.model.Strategy` for a single vehicle; one that joins it shares the places.

    Args:
        name: name of the strategy that it stands for.
        spacing_m: distance of neighbouring places, c4.
        step_m: distance of two frames along a leg, where the vehicle stops for each.
    """

    def __init__(self, name: str, spacing_m: float, step_m: float) -> None:
        self.name = name
        self.spacing_m = spacing_m
        self._step_m = step_m
        self._places_m = _hexagonal(RINGS) * spacing_m

    def init(self, scan_direction_enu: NDArray[np.float64]) -> LoneState:
        """See :class:`~aos_gcs.swarm.model.Strategy`."""
        return LoneState(_point(unit_vector(scan_direction_enu)))

    def tell(self, state: LoneState, observation: Observation) -> LoneState:
        """See :class:`~aos_gcs.swarm.model.Strategy`."""
        if len(observation.vehicle_ids) == 0:
            raise ValueError("the close look needs a vehicle, but the observation has none")
        target_enu_m = state.target_enu_m
        if observation.target_in_view and observation.target_enu_m is not None:
            target_enu_m = _point(observation.target_enu_m)
        positions_enu_m = tuple(map(_point, observation.positions_enu_m))
        return replace(state, positions_enu_m=positions_enu_m, target_enu_m=target_enu_m)

    def ask(self, state: LoneState, rng: np.random.Generator) -> tuple[NDArray[np.float64], LoneState]:  # noqa: ARG002
        """See :class:`~aos_gcs.swarm.model.Strategy`; nothing of it is drawn."""
        n = len(state.positions_enu_m)
        if n == 0:
            raise RuntimeError("nothing has been told since the last call")
        if state.target_enu_m is None:
            next_m = np.array(state.positions_enu_m) + self._step_m * np.array(state.scan_direction_enu)
            return next_m, replace(state, positions_enu_m=())
        chosen = (state.visited + np.arange(n)) % len(self._places_m)
        next_m = np.array(state.target_enu_m) + self._places_m[chosen]
        return next_m, replace(state, positions_enu_m=(), visited=state.visited + n)

    def diagnostics(self, state: LoneState) -> Diagnostics:
        """See :class:`~aos_gcs.swarm.model.Strategy`."""
        return Diagnostics("line" if state.target_enu_m is None else "lone look")


def _hexagonal(rings: int) -> NDArray[np.float64]:
    """Return the places of a hexagonal grid of unit spacing about the origin, ring after ring, shape (n, 2)."""
    corners = [np.array([math.sin(rad), math.cos(rad)]) for rad in np.arange(7) * math.pi / 3.0]
    places = [np.zeros(2)]
    for ring in range(1, rings + 1):
        for start, end in pairwise(corners):
            places += [ring * start + step * (end - start) for step in range(ring)]
    return np.array(places)


def _point(place_m: NDArray[np.float64]) -> Point:
    return float(place_m[0]), float(place_m[1])
