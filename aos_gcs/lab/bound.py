"""The oracle's rows in a campaign: what the best positions would have shown in the same initialisation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from aos_gcs.lab.experiment import closest_approach_m
from aos_gcs.lab.initialisation import Initialisation, target_walk
from aos_gcs.lab.oracle import find_oracle
from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.worlds import Target, World
from aos_gcs.swarm.archive.parameters import AosApsoParameters

ORACLE = "oracle"
"""Name of the oracle in the rows; no strategy of the registry may have it."""
FREEDOM = AosApsoParameters()
"""The oracle may go as far and as near as the strategy that it bounds."""
INTERVAL_S = 3.0
"""Time between looks at a walking target; a standing one is looked at once."""


def oracle_rows(world: World, scenario: Scenario, initialisation: Initialisation) -> Iterator[StepRow]:
    """Yield the oracle's result at some times, the first at 0; it takes a second or more each.

    It knows the forest and the target's place, needs no time to get from one set of positions to the next, and sees
    geometrically whatever the scenario's fidelity.
    """
    walk = target_walk(initialisation, scenario, world)
    heights_m = (scenario.altitude_m + scenario.layer_spacing_m * np.arange(scenario.drones)).tolist()
    spacing_m = min(scenario.spacing_m, FREEDOM.view_spacing_m)
    moments = [0.0] if scenario.target_speed_mps == 0.0 else np.arange(0.0, scenario.duration_s, INTERVAL_S).tolist()
    for step, time_s in enumerate(moments, start=1):
        target = Target(*walk.at(time_s), scenario.posture)
        oracle = find_oracle(world, scenario.camera, target, heights_m, spacing_m, radius_m=FREEDOM.aperture_radius_m)
        positions_m = oracle.positions_enu_m
        distance_m = closest_approach_m(positions_m, positions_m)
        yield StepRow(
            initialisation=initialisation.name,
            strategy=ORACLE,
            step=step,
            time_s=time_s,
            visibility=oracle.visibility,
            area_m2=oracle.area_m2,
            unoccluded_m2=oracle.area_m2 / oracle.visibility if oracle.visibility > 0.0 else 0.0,
            history_visibility=oracle.visibility,
            history_area_m2=oracle.area_m2,
            in_view=oracle.visibility >= scenario.threshold,
            branch=ORACLE,
            leader_id=None,
            evolutionary_factor=None,
            evolutionary_state=None,
            c_s_m=None,
            c_c_m=None,
            east_m=positions_m[:, 0].tolist(),
            north_m=positions_m[:, 1].tolist(),
            height_m=heights_m,
            fitness=[],
            target_east_m=target.position_enu_m[0],
            target_north_m=target.position_enu_m[1],
            target_error_m=None,
            min_distance_m=distance_m,
            min_flight_distance_m=distance_m,
            path_m=0.0,
        )
