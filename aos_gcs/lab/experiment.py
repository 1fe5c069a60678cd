"""One run: a strategy searches one forest, and every step is measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.initialisation import Initialisation, start_positions, target_walk
from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.sensing import SensedTarget, make_sensor
from aos_gcs.lab.timing import step_duration_s
from aos_gcs.lab.worlds import Target, World
from aos_gcs.swarm.model import Strategy


def run_strategy(
    world: World, scenario: Scenario, initialisation: Initialisation, strategy: Strategy[Any], label: str
) -> Iterator[StepRow]:
    """Fly one strategy through one initialisation and yield a row per step, the first at time 0.

    Equal arguments give equal rows. Strategies that start from one initialisation meet the same forest and target,
    and draw from equal generators.

    Args:
        world: world of the initialisation (:func:`aos_gcs.lab.initialisation.open_world`).
        scenario: the rules.
        initialisation: starting conditions.
        strategy: strategy that decides.
        label: name of the strategy in the rows.
    """
    walk = target_walk(initialisation, scenario, world)
    sensor = make_sensor(world, scenario)
    strategy_rng = np.random.default_rng(initialisation.seed)
    noise_rng = np.random.default_rng([initialisation.seed, 2])
    heights_m = scenario.altitude_m + scenario.layer_spacing_m * np.arange(scenario.drones)
    positions_m = previous_m = start_positions(initialisation, scenario, walk)
    state = strategy.init(initialisation.scan_direction_enu)
    shown = unoccluded = np.zeros((1, 1), dtype=np.bool_)
    time_s, step, path_m = 0.0, 0, 0.0
    while time_s <= scenario.duration_s:
        step += 1
        target = Target(*walk.at(time_s), scenario.posture)
        sighting = sensor.sense(np.column_stack([positions_m, heights_m]), target, noise_rng)
        # Rasters move with the target: frames of a walking one are laid on each other where it is.
        shown, unoccluded = shown | sighting.seen, unoccluded | sighting.unoccluded
        shown_cells, unoccluded_cells = int(np.count_nonzero(shown)), int(np.count_nonzero(unoccluded))
        state = strategy.tell(state, replace(sighting.observation, time_s=time_s))
        following_m, state = strategy.ask(state, strategy_rng)
        diagnostics = strategy.diagnostics(state)
        path_m += float(np.linalg.norm(positions_m - previous_m, axis=1).mean())
        yield StepRow(
            initialisation=initialisation.name,
            strategy=label,
            step=step,
            time_s=time_s,
            visibility=sighting.visibility,
            area_m2=sighting.area_m2,
            unoccluded_m2=sighting.unoccluded_m2,
            history_visibility=shown_cells / max(unoccluded_cells, 1),
            history_area_m2=shown_cells * sighting.cell_m2,
            in_view=sighting.observation.target_in_view,
            branch=diagnostics.branch,
            leader_id=diagnostics.leader_id,
            evolutionary_factor=diagnostics.evolutionary_factor,
            evolutionary_state=diagnostics.evolutionary_state,
            c_s_m=diagnostics.c_s_m,
            c_c_m=diagnostics.c_c_m,
            east_m=positions_m[:, 0].tolist(),
            north_m=positions_m[:, 1].tolist(),
            height_m=heights_m.tolist(),
            fitness=sighting.observation.fitness.tolist(),
            target_east_m=target.position_enu_m[0],
            target_north_m=target.position_enu_m[1],
            target_error_m=_target_error_m(sighting, target),
            min_distance_m=closest_approach_m(positions_m, positions_m),
            min_flight_distance_m=closest_approach_m(previous_m, positions_m),
            path_m=path_m,
        )
        previous_m, positions_m = positions_m, following_m
        time_s += step_duration_s(positions_m - previous_m, scenario)


def closest_approach_m(start_m: NDArray[np.float64], end_m: NDArray[np.float64]) -> float:
    """Return the smallest distance between two drones that fly straight and arrive together.

    Args:
        start_m: starting positions, shape (n, 2), n at least 2.
        end_m: end positions, shape (n, 2).
    """
    first, second = _pairs(len(start_m))
    apart_m = start_m[first] - start_m[second]
    change_m = end_m[first] - end_m[second] - apart_m
    # |apart + share * change| is least where it is at a right angle to the change.
    square = np.sum(change_m**2, axis=1)
    share = np.clip(-np.sum(apart_m * change_m, axis=1) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return float(np.linalg.norm(apart_m + share[:, None] * change_m, axis=1).min())


@lru_cache(maxsize=8)
def _pairs(count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and the second of every pair of so many."""
    first, second = np.triu_indices(count, k=1)
    return first, second


def _target_error_m(sighting: SensedTarget, target: Target) -> float | None:
    estimate_enu_m = sighting.observation.target_enu_m
    if estimate_enu_m is None:
        return None
    return float(np.linalg.norm(estimate_enu_m - np.array(target.position_enu_m)))
