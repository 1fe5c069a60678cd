"""Share of the target that single views see, which calibrates the density of a forest."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.lab.initialisation import draw_initialisations, open_world, target_walk
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.worlds import Target

VIEW_RADIUS_M = 12.0
"""Radius of the disc above the target from which views are drawn: where a swarm gathers."""


@dataclass(frozen=True, slots=True)
class SingleViewVisibility:
    """The visible share of a target in one view, over forests."""

    mean: float
    standard_error: float
    """Standard error of the mean over forests, which are independent; views of one forest are not."""
    lower_quartile: float
    """Lower quartile of the forests' means."""
    upper_quartile: float


def single_view_visibility(
    scenario: Scenario, *, worlds: int, views: int, seed: int, advance: Callable[[int], None]
) -> SingleViewVisibility:
    """Measure nadir views from the scenario's layers, spread evenly over a disc above the target.

    Args:
        scenario: its forest, target, layers and camera.
        worlds: number of forests, two at least.
        views: number of views per forest.
        seed: random seed of the forests and views.
        advance: called with 1 after each forest.
    """
    # A small forest is enough below the disc, and quickly built.
    small = dataclasses.replace(scenario, forest_side_m=60.0)
    means = []
    for number, initialisation in enumerate(draw_initialisations(worlds, seed, small)):
        rng = np.random.default_rng([seed, number, 1])
        world = open_world(initialisation, small)
        target = Target(*target_walk(initialisation, small, world).at(0.0), small.posture)
        radius_m = VIEW_RADIUS_M * np.sqrt(rng.uniform(size=views))
        angle_rad = rng.uniform(0.0, 2 * math.pi, views)
        height_m = small.altitude_m + small.layer_spacing_m * rng.integers(small.drones, size=views)
        offset_m = np.column_stack([radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad), height_m])
        poses = [nadir_pose(position) for position in np.array([*target.position_enu_m, 0.0]) + offset_m]
        seen = world.view_target(poses, small.camera, target)
        unoccluded = seen.unoccluded.sum(axis=(1, 2))
        means.append(float(np.mean(seen.seen.sum(axis=(1, 2)) / np.maximum(unoccluded, 1))))
        advance(1)
    lower, upper = np.quantile(means, [0.25, 0.75])
    return SingleViewVisibility(
        float(np.mean(means)), float(np.std(means, ddof=1)) / math.sqrt(worlds), float(lower), float(upper)
    )
