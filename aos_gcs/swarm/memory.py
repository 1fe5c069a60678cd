"""Optional memories of the drones: where each has seen most, and where the swarm has sampled already.

Source: AOS-APSO paper, section Conclusion, which asks for both. Both are switches that are off by default, for the
published strategies follow the 'no history' paradigm. What is remembered belongs to one sighting of the target and is
forgotten when the target is lost.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.parameters import SwarmParameters
from aos_gcs.swarm.state import PersonalBest, SwarmState

MAX_SAMPLED = 400
"""Spots that are remembered, the latest ones: 40 steps of ten drones."""

DETOUR_ANGLES = 12
DETOUR_RADII = (1.0, 1.5, 2.0, 3.0, 4.0)
"""Candidates around a spot that is not free: so many directions, at these multiples of the radius."""


def remember(state: SwarmState, observation: Observation, parameters: SwarmParameters) -> SwarmState:
    """Return the state with memories brought up to date, as far as they are switched on."""
    if state.situation is None or state.situation.leader_id is None:
        return replace(state, personal_bests=(), sampled_enu_m=())
    if parameters.personal_best_memory:
        state = replace(state, personal_bests=_personal_bests(state.personal_bests, observation))
    if parameters.revisit_radius_m is not None:
        here = tuple((float(east_m), float(north_m)) for east_m, north_m in observation.positions_enu_m)
        state = replace(state, sampled_enu_m=(state.sampled_enu_m + here)[-MAX_SAMPLED:])
    return state


def clear_of_sampled(
    positions_enu_m: NDArray[np.float64],
    sampled_enu_m: NDArray[np.float64],
    radius_m: float,
    distance_m: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return positions of which none lies on a spot that has been sampled, shape (n, 2).

    A position within the radius of such a spot moves to the nearest of some candidates around it that is clear of all
    spots and far enough from all other positions; where none is, to the one that comes nearest to it.

    Args:
        positions_enu_m: shape (n, 2), n >= 2, metres.
        sampled_enu_m: shape (m, 2), metres.
        radius_m: distance that counts as the same spot, metres.
        distance_m: least distance of a candidate from all other positions, metres.
        rng: turns the candidates, so that no direction is preferred.
    """
    positions_m = positions_enu_m.copy()
    for row in np.flatnonzero(_clearances_m(positions_m, sampled_enu_m) < radius_m):
        candidates_m = positions_m[row] + radius_m * _detours(rng)
        from_spots = _clearances_m(candidates_m, sampled_enu_m) / radius_m
        from_others = _clearances_m(candidates_m, np.delete(positions_m, row, axis=0)) / distance_m
        margins = np.minimum(1.0, np.minimum(from_spots, from_others))
        positions_m[row] = candidates_m[margins.argmax()]
    return positions_m


def _personal_bests(bests: tuple[PersonalBest, ...], observation: Observation) -> tuple[PersonalBest, ...]:
    """Return the best sighting of each vehicle; one without a frame keeps what it remembers."""
    by_vehicle = {best.vehicle_id: best for best in bests}
    rows = zip(observation.vehicle_ids, observation.positions_enu_m, observation.fitness, strict=True)
    for vehicle_id, (east_m, north_m), fitness in rows:
        known = by_vehicle.get(int(vehicle_id))
        if np.isfinite(fitness) and (known is None or fitness > known.fitness):
            by_vehicle[int(vehicle_id)] = PersonalBest(int(vehicle_id), (float(east_m), float(north_m)), float(fitness))
    return tuple(by_vehicle[vehicle_id] for vehicle_id in sorted(by_vehicle))


def _clearances_m(positions_m: NDArray[np.float64], spots_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each position's distance to the nearest spot, shape (n,)."""
    clearances_m: NDArray[np.float64] = np.linalg.norm(positions_m[:, None] - spots_m[None, :], axis=2).min(axis=1)
    return clearances_m


def _detours(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return steps around the origin, the shorter ones first, shape (k, 2)."""
    angles_rad = rng.uniform(0.0, 2.0 * np.pi) + np.arange(DETOUR_ANGLES) * (2.0 * np.pi / DETOUR_ANGLES)
    directions = np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
    return np.concatenate([radius * directions for radius in DETOUR_RADII])
