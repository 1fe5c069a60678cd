"""Paths of walking targets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TRUNK_CLEARANCE_M = 2.0
"""Least distance of the target from a trunk, as in the simulated missions."""
_PLACES = 64
_REACH_M = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A way along straight lines at constant speed; a target that has arrived stays."""

    corners_enu_m: NDArray[np.float64]
    """Shape (k, 2), one at least."""
    speed_mps: float
    heading_rad: float
    """Heading of a still target, clockwise from north; a walking one faces its direction of motion."""

    def at(self, time_s: float) -> tuple[tuple[float, float], float]:
        """Return position (east, north) and heading."""
        legs_m = np.diff(self.corners_enu_m, axis=0)
        ends_m = np.cumsum(np.linalg.norm(legs_m, axis=1))
        walked_m = self.speed_mps * time_s
        leg = int(np.searchsorted(ends_m, walked_m, side="right"))
        if leg == len(legs_m):
            heading_rad = _heading_rad(legs_m[-1]) if leg else self.heading_rad
            return _point(self.corners_enu_m[-1]), heading_rad
        length_m = float(np.linalg.norm(legs_m[leg]))
        share = 1.0 - (ends_m[leg] - walked_m) / length_m
        return _point(self.corners_enu_m[leg] + share * legs_m[leg]), _heading_rad(legs_m[leg])


def stand(position_enu_m: NDArray[np.float64], heading_rad: float) -> Route:
    """Return the walk of a target that stays."""
    return Route(position_enu_m[None, :], 0.0, heading_rad)


def draw_walk(
    rng: np.random.Generator,
    start_enu_m: NDArray[np.float64],
    *,
    speed_mps: float,
    duration_s: float,
    low_enu_m: NDArray[np.float64],
    high_enu_m: NDArray[np.float64],
) -> Route:
    """Return a walk from corner to corner in a rectangle, as long as the time; it passes trees as if they gave way."""
    corners_m = [start_enu_m]
    remaining_m = speed_mps * duration_s
    while remaining_m > 0.0:
        corners_m.append(rng.uniform(low_enu_m, high_enu_m))
        remaining_m -= float(np.linalg.norm(corners_m[-1] - corners_m[-2]))
    return Route(np.array(corners_m), speed_mps, heading_rad=0.0)


def clear_of_trunks(
    rng: np.random.Generator, position_enu_m: NDArray[np.float64], trunks_enu_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the position, shape (2,), or a random one around it where it is too near a trunk.

    Not the nearest clear one: at the edge of a trunk's surroundings it is darker than in the mean of the forest. Where
    trees stand too densely, it is the clearest of many.
    """
    if len(trunks_enu_m) == 0:
        return position_enu_m
    places_m = np.vstack([position_enu_m, position_enu_m + rng.uniform(-_REACH_M, _REACH_M, (_PLACES, 2))])
    clearance_m = np.linalg.norm(places_m[:, None] - trunks_enu_m[None], axis=2).min(axis=1)
    return np.asarray(places_m[int(np.argmax(np.minimum(clearance_m, TRUNK_CLEARANCE_M)))])


def free_place(
    rng: np.random.Generator, middle_enu_m: NDArray[np.float64], reach_m: float, trunks_enu_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a random place beside the trees, shape (2,), at most ``reach_m`` from the middle on both axes."""
    while True:
        place_m = middle_enu_m + rng.uniform(-reach_m, reach_m, 2)
        if not len(trunks_enu_m) or np.linalg.norm(trunks_enu_m - place_m, axis=1).min() >= TRUNK_CLEARANCE_M:
            return np.asarray(place_m)


def _heading_rad(direction_enu: NDArray[np.float64]) -> float:
    return math.atan2(direction_enu[0], direction_enu[1])


def _point(row: NDArray[np.float64]) -> tuple[float, float]:
    return (float(row[0]), float(row[1]))
