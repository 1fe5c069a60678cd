"""The steps that AOS-PSO and AOS-APSO share: taking in an observation, and the moves of the two branches.

Source: AOS-APSO paper, algorithm PSO update for AOS drone swarms (``alg:pso-for-aos``); algorithms.md section 3c.
Rows are sorted by vehicle id before anything is drawn or summed, so that the order in which vehicles are reported
changes nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.evolution import evolutionary_factor
from aos_gcs.swarm.line import line_by_index, line_by_projection, unit_vector
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.parameters import SwarmParameters
from aos_gcs.swarm.scatter import scatter
from aos_gcs.swarm.state import Point, Situation, SwarmState, TargetTrack


def initial_state(scan_direction_enu: NDArray[np.float64]) -> SwarmState:
    """Return the state before the first step.

    Raises:
        ValueError: the direction has no length.
    """
    return SwarmState(scan_direction_enu=_point(unit_vector(np.asarray(scan_direction_enu, dtype=np.float64))))


def take_in(state: SwarmState, observation: Observation) -> SwarmState:
    """Return the state after an observation: branch, leader, track and scanning direction.

    Raises:
        ValueError: shapes do not fit, an id occurs twice, a position is not finite, or fewer than two vehicles.
    """
    _check(observation)
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
    situation = Situation(
        vehicle_ids=tuple(int(vehicle_id) for vehicle_id in observation.vehicle_ids),
        positions_enu_m=tuple(map(_point, observation.positions_enu_m)),
        leader_id=_leader_id(observation) if observation.target_in_view else None,
    )
    return replace(state, scan_direction_enu=scan_direction_enu, track=track, situation=situation, awaits_ask=True)


def sorted_positions(situation: Situation) -> tuple[NDArray[np.float64], NDArray[np.intp], int | None]:
    """Return positions in the order of vehicle ids (n, 2), the sorting indices (n,), and the leader's row in it."""
    order = np.argsort(situation.vehicle_ids)
    positions_m = np.array(situation.positions_enu_m)[order]
    if situation.leader_id is None:
        return positions_m, order, None
    return positions_m, order, sorted(situation.vehicle_ids).index(situation.leader_id)


def observed_evolutionary_factor(state: SwarmState) -> float | None:
    """Return e_f of the latest observation; None in the default branch."""
    if state.situation is None:
        return None
    positions_m, _, leader = sorted_positions(state.situation)
    return None if leader is None else evolutionary_factor(positions_m, leader)


def next_positions(
    state: SwarmState, parameters: SwarmParameters, c_s_m: float, c_c_m: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return where the drones go next, shape (n, 2), in the order of the latest observation.

    Raises:
        RuntimeError: nothing has been told since the last call.
    """
    if state.situation is None or not state.awaits_ask:
        raise RuntimeError("ask() needs an observation first: call tell() before each ask()")
    positions_m, order, leader = sorted_positions(state.situation)
    if leader is None:
        moved_m = default_move(positions_m, state, parameters)
    else:
        moved_m = pso_move(positions_m, leader, parameters, c_s_m=c_s_m, c_c_m=c_c_m, rng=rng)
    result_m = np.empty_like(moved_m)
    result_m[order] = moved_m
    return result_m


def default_move(
    positions_enu_m: NDArray[np.float64], state: SwarmState, parameters: SwarmParameters
) -> NDArray[np.float64]:
    """Return the positions after one step of scanning in line, shape (n, 2) (``alg:pso-for-aos``, lines 4 to 6)."""
    scan_direction = np.array(state.scan_direction_enu)
    line = line_by_projection if parameters.projection_line else line_by_index
    places_m = line(positions_enu_m, scan_direction, parameters.c4_m)
    velocity_m = scan_step_m(state.track, parameters) * scan_direction + parameters.c5 * (places_m - positions_enu_m)
    return positions_enu_m + velocity_m


def pso_move(
    positions_enu_m: NDArray[np.float64],
    leader: int,
    parameters: SwarmParameters,
    *,
    c_s_m: float,
    c_c_m: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return the positions after one step of following the leader, shape (n, 2).

    ``line:aos-pso-velocity-update`` and ``line:scattering``; the social term of the leader, and of a drone that
    coincides with it, is zero.
    """
    angles_rad = rng.uniform(0.0, 2.0 * np.pi, len(positions_enu_m))
    random_units = np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
    to_leader_m = positions_enu_m[leader] - positions_enu_m
    distances_m = np.linalg.norm(to_leader_m, axis=1, keepdims=True)
    leader_units = np.divide(to_leader_m, distances_m, out=np.zeros_like(to_leader_m), where=distances_m > 0.0)
    velocity_m = c_c_m * random_units + c_s_m * leader_units
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


def _check(observation: Observation) -> None:
    n = len(observation.vehicle_ids)
    if n < 2:
        raise ValueError(f"a swarm has two or more vehicles, but {n} were told")
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
