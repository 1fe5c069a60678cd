"""The steps that strategies share: taking in an observation, and the moves of the default and the PSO branch.

Source: AOS-APSO paper, algorithm PSO update for AOS drone swarms (``alg:pso-for-aos``).
Rows are sorted by vehicle id before anything is drawn or summed, so that the order in which vehicles are reported
changes nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.optimisers.evolution import evolutionary_factor
from aos_gcs.optimisers.randomness import Draw, attraction
from aos_gcs.swarm.line import line_by_index, line_by_projection, unit_vector
from aos_gcs.swarm.memory import clear_of_sampled
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.parameters import LineParameters, SwarmParameters
from aos_gcs.swarm.scatter import scatter
from aos_gcs.swarm.state import LatestObservation, Point, SwarmState, TargetTrack

SPHERICAL_EXPONENT = 3
"""m of the random points around personal bests; 3 works well for most uses (``eq:pso-sphere``)."""


def initial_state(scan_direction_enu: NDArray[np.float64]) -> SwarmState:
    """Return the state before the first step.

    Raises:
        ValueError: the direction has no length.
    """
    return SwarmState(scan_direction_enu=_point(unit_vector(np.asarray(scan_direction_enu, dtype=np.float64))))


def take_in(state: SwarmState, observation: Observation, min_vehicles: int = 2) -> SwarmState:
    """Return the state after an observation: branch, leader, track and scanning direction.

    Raises:
        ValueError: shapes do not fit, an id occurs twice, a position is not finite, or too few vehicles.
    """
    check_observation(observation, min_vehicles)
    target_enu_m = observation.target_enu_m if observation.target_in_view else None
    track, scan_direction_enu = state.track, state.scan_direction_enu
    if target_enu_m is not None:
        track = _extended(track, _point(target_enu_m))
        # line:updating-SD; over the target itself there is no direction, and the old one stays.
        towards_target_m = target_enu_m - observation.positions_enu_m.mean(axis=0)
        if np.linalg.norm(towards_target_m) > 1e-9:
            scan_direction_enu = _point(unit_vector(towards_target_m))
    elif track is not None:
        track = replace(track, in_view=False)
    situation = LatestObservation(
        vehicle_ids=tuple(int(vehicle_id) for vehicle_id in observation.vehicle_ids),
        positions_enu_m=tuple(map(_point, observation.positions_enu_m)),
        leader_id=_leader_id(observation) if observation.target_in_view else None,
    )
    return replace(state, scan_direction_enu=scan_direction_enu, track=track, situation=situation, awaits_ask=True)


def sorted_positions(situation: LatestObservation) -> tuple[NDArray[np.float64], NDArray[np.intp], int | None]:
    """Return positions in the order of vehicle ids (n, 2), the sorting indices (n,), and the leader's row in it."""
    order = np.argsort(situation.vehicle_ids)
    positions_m = np.array(situation.positions_enu_m)[order]
    if situation.leader_id is None:
        return positions_m, order, None
    return positions_m, order, sorted(situation.vehicle_ids).index(situation.leader_id)


def in_told_order(rows: NDArray[np.float64], order: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return rows that are sorted by vehicle id in the order of the observation: undoes :func:`sorted_positions`."""
    told = np.empty_like(rows)
    told[order] = rows
    return told


def observed_evolutionary_factor(state: SwarmState) -> float | None:
    """Return e_f of the latest observation; None in the default branch."""
    if state.situation is None:
        return None
    positions_m, _, leader = sorted_positions(state.situation)
    return None if leader is None else evolutionary_factor(positions_m, leader)


def check_told(state: SwarmState) -> LatestObservation:
    """Return the situation to decide about.

    Raises:
        RuntimeError: nothing has been told since the last call of ``ask``.
    """
    if state.situation is None or not state.awaits_ask:
        raise RuntimeError("ask() needs an observation first: call tell() before each ask()")
    return state.situation


def next_positions(
    state: SwarmState, parameters: SwarmParameters, c_s_m: float, c_c_m: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return where the drones go next, shape (n, 2), in the order of the latest observation.

    Raises:
        RuntimeError: nothing has been told since the last call.
    """
    situation = check_told(state)
    positions_m, order, leader = sorted_positions(situation)
    if leader is None:
        moved_m = default_move(positions_m, state, parameters)
    else:
        bests_m = _best_positions(state, situation, parameters)
        moved_m = pso_move(positions_m, leader, parameters, c_s_m=c_s_m, c_c_m=c_c_m, rng=rng, bests_enu_m=bests_m)
        if parameters.revisit_radius_m is not None and state.sampled_enu_m:
            sampled_m, distance_m = np.array(state.sampled_enu_m), parameters.c4_m / 2.0
            moved_m = clear_of_sampled(moved_m, sampled_m, parameters.revisit_radius_m, distance_m, rng)
    return in_told_order(moved_m, order)


def default_move(
    positions_enu_m: NDArray[np.float64], state: SwarmState, parameters: SwarmParameters
) -> NDArray[np.float64]:
    """Return the positions after one step of scanning in line, shape (n, 2) (``alg:pso-for-aos``, lines 4 to 6)."""
    step_m = scan_step_m(state.track, parameters)
    return line_move(positions_enu_m, np.array(state.scan_direction_enu), step_m, parameters)


def line_move(
    positions_enu_m: NDArray[np.float64],
    scan_direction: NDArray[np.float64],
    step_m: float,
    parameters: LineParameters,
) -> NDArray[np.float64]:
    """Return the positions after one step of scanning in line and closing up, shape (n, 2)."""
    line = line_by_projection if parameters.projection_line else line_by_index
    places_m = line(positions_enu_m, scan_direction, parameters.c4_m)
    velocity_m = step_m * scan_direction + parameters.c5 * (places_m - positions_enu_m)
    return positions_enu_m + velocity_m


def pso_move(
    positions_enu_m: NDArray[np.float64],
    leader: int,
    parameters: SwarmParameters,
    *,
    c_s_m: float,
    c_c_m: float,
    rng: np.random.Generator,
    bests_enu_m: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the positions after one step of following the leader, shape (n, 2).

    ``line:aos-pso-velocity-update`` and ``line:scattering``; the social term of the leader, and of a drone that
    coincides with it, is zero. With personal bests, shape (n, 2), the cognitive term points to a random point around
    them (``eq:pso-sphere``), and in a random direction, as published, for a drone that is at its best now.
    """
    angles_rad = rng.uniform(0.0, 2.0 * np.pi, len(positions_enu_m))
    cognitive_units = np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
    if bests_enu_m is not None:
        drawn = Draw(rng.uniform(size=(len(positions_enu_m), 1)), cognitive_units)
        to_bests_m = attraction(bests_enu_m - positions_enu_m, drawn, SPHERICAL_EXPONENT)
        cognitive_units = _unit_rows(to_bests_m, otherwise=cognitive_units)
    to_leader_m = positions_enu_m[leader] - positions_enu_m
    leader_units = _unit_rows(to_leader_m, otherwise=np.zeros_like(to_leader_m))
    velocity_m = c_c_m * cognitive_units + c_s_m * leader_units
    return scatter(
        positions_enu_m + velocity_m,
        parameters.c4_m,
        rng,
        leader=leader if parameters.leader_stabilised else None,
        cutoff_m=parameters.repulsion_cutoff_m,
    )


def scan_step_m(track: TargetTrack | None, parameters: SwarmParameters) -> float:
    """Return the scanning step, metres: c3, or faster after a target that has been seen to move.

    Never slower than c3, for a line that stands where a still target was lost would see the same for ever; never
    above c4, for larger steps would leave gaps.
    """
    if track is None or not parameters.follow_target_speed:
        return parameters.c3_m
    return max(parameters.c3_m, min(track.step_m, parameters.c4_m))


def _best_positions(
    state: SwarmState, situation: LatestObservation, parameters: SwarmParameters
) -> NDArray[np.float64] | None:
    """Return the personal bests in the order of vehicle ids, shape (n, 2); None where that memory is off.

    A vehicle that has not seen anything yet counts as being at its best.
    """
    if not parameters.personal_best_memory:
        return None
    known_m = {best.vehicle_id: best.position_enu_m for best in state.personal_bests}
    here_m = dict(zip(situation.vehicle_ids, situation.positions_enu_m, strict=True))
    return np.array([known_m.get(vehicle_id, here_m[vehicle_id]) for vehicle_id in sorted(here_m)])


def _unit_rows(vectors: NDArray[np.float64], otherwise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows scaled to length 1, and those of ``otherwise`` where they have no length."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    units: NDArray[np.float64] = np.divide(vectors, lengths, out=otherwise.copy(), where=lengths > 0.0)
    return units


def check_observation(observation: Observation, min_vehicles: int = 2) -> None:
    """Check an observation.

    Raises:
        ValueError: shapes do not fit, an id occurs twice, a position is not finite, or too few vehicles.
    """
    n = len(observation.vehicle_ids)
    if n < min_vehicles:
        raise ValueError(f"the strategy needs {min_vehicles} or more vehicles, but the observation has {n}")
    if len(set(observation.vehicle_ids)) != n:
        raise ValueError(f"vehicle ids must differ, but were {observation.vehicle_ids}")
    if np.shape(observation.positions_enu_m) != (n, 2):
        raise ValueError(f"positions need shape ({n}, 2), but have {np.shape(observation.positions_enu_m)}")
    if np.shape(observation.fitness) != (n,):
        raise ValueError(f"fitness needs shape ({n},), but has {np.shape(observation.fitness)}")
    if not np.isfinite(observation.positions_enu_m).all():
        raise ValueError("positions must be finite; leave out a vehicle whose position is unknown")
    target_enu_m = observation.target_enu_m
    if target_enu_m is not None and (np.shape(target_enu_m) != (2,) or not np.isfinite(target_enu_m).all()):
        raise ValueError(f"the target position needs shape (2,) and finite values, but was {target_enu_m}")


def _leader_id(observation: Observation) -> int | None:
    """Return the imaging's choice, else the lowest id of the best fitness; a vehicle without a frame never leads."""
    delivered = ~np.isnan(observation.fitness)
    vehicle_ids = np.array(observation.vehicle_ids)[delivered]
    fitness = dict(zip(vehicle_ids.tolist(), observation.fitness[delivered].tolist(), strict=True))
    if observation.leader_id in fitness:
        return observation.leader_id
    return min(fitness, key=lambda vehicle_id: (-fitness[vehicle_id], vehicle_id), default=None)


def _extended(track: TargetTrack | None, target_enu_m: Point) -> TargetTrack:
    if track is None or not track.in_view:
        return TargetTrack(target_enu_m, target_enu_m, sightings=1, in_view=True)
    return replace(track, last_enu_m=target_enu_m, sightings=track.sightings + 1)


def _point(row: NDArray[np.float64]) -> Point:
    return (float(row[0]), float(row[1]))
