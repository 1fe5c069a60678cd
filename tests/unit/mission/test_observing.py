"""What a strategy is told of a step."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.imaging.model import FocalGrid, StepAnalysis, VehicleMasks
from aos_gcs.mission.search.decisions.observing import make_observation
from aos_gcs.swarm.archive.strategy import make_aos_archive

MARKED = np.zeros((2, 3, 4), np.bool_)
MARKED[0, 1, 2] = MARKED[1, 0, 0] = True
ANALYSIS = StepAnalysis(
    grid=FocalGrid(0.0, 1.0, 0.5, 2, 2, 1.5),
    coverage=np.ones((2, 2), np.uint16),
    anomaly_count=np.zeros((2, 2), np.uint16),
    blob=None,
    vehicle_ids=(7, 3),
    fitness=np.array([0.7, 0.3]),
    leader_id=7,
    masks=VehicleMasks(MARKED, 10.0, 20.0, 0.25),
)
POSITIONS = np.array([[0.0, 0.0, 35.0], [5.0, 0.0, 37.0], [9.0, 0.0, 39.0]])


def test_rows_are_in_the_order_of_the_swarm() -> None:
    observation = make_observation((3, 5, 7), POSITIONS, ANALYSIS, np.array([1.0, 2.0]))
    assert observation.vehicle_ids == (3, 5, 7)
    np.testing.assert_array_equal(observation.fitness, [0.3, np.nan, 0.7])
    assert observation.heights_m is not None
    np.testing.assert_allclose(observation.heights_m, [33.5, 35.5, 37.5])
    assert observation.target_in_view
    assert observation.leader_id == 7
    masks = observation.masks
    assert masks is not None
    np.testing.assert_array_equal(masks.marked, [MARKED[1], np.zeros((3, 4)), MARKED[0]])
    assert (masks.west_m, masks.north_m, masks.resolution_m) == (10.0, 20.0, 0.25)


def test_out_of_view_there_are_no_masks() -> None:
    observation = make_observation((3, 5, 7), POSITIONS, ANALYSIS, None)
    assert not observation.target_in_view
    assert observation.target_enu_m is None
    assert observation.masks is None


@pytest.mark.parametrize("up_m", [1.5, -10.0])
def test_a_vehicle_that_reports_to_be_below_the_focal_plane_leaves_no_lines_of_sight(up_m: float) -> None:
    positions_enu_m = POSITIONS.copy()
    positions_enu_m[1, 2] = up_m
    observation = make_observation((3, 5, 7), positions_enu_m, ANALYSIS, np.array([1.0, 2.0]))
    assert observation.heights_m is None
    strategy = make_aos_archive({})
    state = strategy.tell(strategy.init(np.array([0.0, 1.0])), observation)
    next_enu_m, _ = strategy.ask(state, np.random.default_rng(1))
    assert np.isfinite(next_enu_m).all()
