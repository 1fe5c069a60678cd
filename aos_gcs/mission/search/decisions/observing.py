"""Observation of a step for the strategy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import StepAnalysis, VehicleMasks
from aos_gcs.swarm.model import Observation, TargetMasks


def make_observation(
    vehicle_ids: Sequence[int],
    positions_enu_m: NDArray[np.float64],
    analysis: StepAnalysis,
    target_enu_m: NDArray[np.float64] | None,
    time_s: float | None = None,
) -> Observation:
    """Return a step's observation.

    Args:
        vehicle_ids: vehicles of the swarm, with those that delivered no frame.
        positions_enu_m: their positions, shape (n, 3).
        analysis: result of the frames.
        target_enu_m: position of the target in view, shape (2,); None when no target is in view.
        time_s: time of the step since the start of the mission.
    """
    row_of = {vehicle_id: row for row, vehicle_id in enumerate(analysis.vehicle_ids)}
    rows = [row_of.get(vehicle_id) for vehicle_id in vehicle_ids]
    in_view = target_enu_m is not None
    heights_m = positions_enu_m[:, 2] - analysis.grid.height_m
    return Observation(
        vehicle_ids=tuple(vehicle_ids),
        positions_enu_m=positions_enu_m[:, :2],
        fitness=np.array([np.nan if row is None else analysis.fitness[row] for row in rows]),
        target_in_view=in_view,
        target_enu_m=target_enu_m,
        leader_id=analysis.leader_id,
        # One that reports to be below the plane, such as after a restart in the air, has no line of sight to it.
        heights_m=heights_m if bool((heights_m > 0.0).all()) else None,
        masks=_target_masks(analysis.masks, rows) if in_view and analysis.masks is not None else None,
        time_s=time_s,
    )


def _target_masks(masks: VehicleMasks, rows: Sequence[int | None]) -> TargetMasks:
    nothing = np.zeros(masks.marked.shape[1:], dtype=np.bool_)
    marked = np.array([nothing if row is None else masks.marked[row] for row in rows])
    return TargetMasks(marked, masks.west_m, masks.north_m, masks.resolution_m)
