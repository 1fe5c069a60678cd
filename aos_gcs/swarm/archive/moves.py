"""Waypoints from goals: assignment of drones, length of a step, and distances between drones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

FloatArray = NDArray[np.float64]

HOLDS_WITHIN_M = 0.3
"""A drone as near to its goal as that holds its place; others give way to it."""
STILL_WITHIN_M = 0.1
"""A drone as near to its goal as that does not move: in the canopy its line is off by a quarter of it."""
MARGIN_M = 0.01
"""Extra distance by which drones are pushed apart, so that rounding does not matter."""
MAX_PUSHES = 20
"""Rounds of pushing; three are enough unless drones are crowded."""


def assigned(places_m: FloatArray, goals_m: FloatArray) -> NDArray[np.intp]:
    """Return for each drone the index of its goal, or -1, so that the squared ways sum up to the least.

    Args:
        places_m: positions of the drones, shape (n, 2).
        goals_m: position of each drone at each goal, shape (n, k, 2): drones fly in different layers.
    """
    drones, goals = linear_sum_assignment(((goals_m - places_m[:, None]) ** 2).sum(axis=-1))
    goal_of = np.full(len(places_m), -1, dtype=np.intp)
    goal_of[drones] = goals
    return goal_of


def stepped(places_m: FloatArray, goals_m: FloatArray, step_m: float) -> FloatArray:
    """Return the places after one step towards the goals, none longer than ``step_m``, shape (n, 2)."""
    ways_m = goals_m - places_m
    lengths_m = np.linalg.norm(ways_m, axis=1, keepdims=True)
    return np.asarray(places_m + ways_m * np.minimum(1.0, step_m / np.maximum(lengths_m, 1e-9)))


def random_ways(rng: np.random.Generator, count: int, length_m: float) -> FloatArray:
    """Return ways of a length in random directions, shape (count, 2)."""
    angles = rng.uniform(0.0, 2.0 * np.pi, count)
    return length_m * np.column_stack([np.cos(angles), np.sin(angles)])


def kept_apart(
    waypoints_m: FloatArray,
    places_m: FloatArray,
    holds: NDArray[np.bool_],
    distance_m: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Return waypoints, shape (n, 2), pushed at least ``distance_m`` apart.

    A drone that holds its place moves only for another one that holds; coincident ones part in a random direction.
    Where there is no room, drones stay; only if they stand too near already do distances come out smaller.

    Args:
        waypoints_m: proposed waypoints of the drones, shape (n, 2).
        places_m: present positions, shape (n, 2).
        holds: True for vehicles that hold their place, shape (n,).
        distance_m: to keep.
        rng: for coincident ones.
    """
    apart_m = waypoints_m.copy()
    for _ in range(MAX_PUSHES):
        first, second = np.nonzero(np.triu(_too_near(apart_m, distance_m)))
        if len(first) == 0:
            return apart_m
        for i, j in zip(first.tolist(), second.tolist(), strict=True):
            push_m = _push(apart_m[i] - apart_m[j], distance_m + MARGIN_M, rng)
            share = 0.5 if holds[i] == holds[j] else float(holds[j])
            apart_m[i] += share * push_m
            apart_m[j] -= (1.0 - share) * push_m
    stays = np.zeros(len(apart_m), dtype=np.bool_)
    while (crowded := _too_near(apart_m, distance_m).any(axis=1) & ~stays).any():
        stays |= crowded
        apart_m[stays] = places_m[stays]
    return apart_m


def _too_near(places_m: FloatArray, distance_m: float) -> NDArray[np.bool_]:
    """Return which drones are too near to which others, shape (n, n)."""
    near = np.linalg.norm(places_m[:, None] - places_m, axis=2) < distance_m
    np.fill_diagonal(near, False)
    return np.asarray(near)


def _push(way_m: FloatArray, distance_m: float, rng: np.random.Generator) -> FloatArray:
    """Return by how much a drone must move away from another one, shape (2,), given its place relative to it."""
    length_m = float(np.linalg.norm(way_m))
    if length_m < 1e-6:
        angle_rad = rng.uniform(0.0, 2.0 * np.pi)
        return distance_m * np.array([np.cos(angle_rad), np.sin(angle_rad)])
    # An earlier push may already have parted them.
    return np.asarray(way_m * max(0.0, distance_m / length_m - 1.0))
