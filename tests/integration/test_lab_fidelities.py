"""The two fidelities of the laboratory see the same, and rank strategies alike."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab import Fidelity, Scenario, draw_initialisations, open_world, parse_strategies, run_strategy
from aos_gcs.lab.sensing import make_sensor
from aos_gcs.lab.worlds import ErrorGrade, Target, World, WorldParameters, build_world

SCENARIO = Scenario(
    trees_per_ha=200.0,
    forest_side_m=60.0,
    drones=6,
    fov_deg=40.0,
    image_size_px=256,
    start_distance_m=10.0,
    duration_s=6.0,
)
TARGET = Target((0.0, 28.0))


@pytest.fixture(scope="module")
def forest() -> World:
    return build_world(WorldParameters(seed=4, trees_per_ha=200.0, side_m=40.0, errors=ErrorGrade.NONE))


def positions_m(seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    return np.column_stack([np.array(TARGET.position_enu_m) + rng.uniform(-5, 5, (4, 2)), 35.0 + np.arange(4)])


def test_both_see_the_target_at_one_place_and_to_one_extent(forest: World) -> None:
    geometric = make_sensor(forest, SCENARIO)
    imaging = make_sensor(forest, dataclasses.replace(SCENARIO, fidelity=Fidelity.IMAGING))
    rng = np.random.default_rng(0)
    exact, imaged = (sensor.sense(positions_m(0), TARGET, rng) for sensor in (geometric, imaging))
    assert exact.unoccluded_m2 == imaged.unoccluded_m2
    assert exact.observation.target_in_view
    assert imaged.observation.target_in_view
    # A pixel of 0.1 m rounds the outline of a person of 0.5 m.
    assert imaged.visibility == pytest.approx(exact.visibility, abs=0.15)
    for sighting in (exact, imaged):
        assert sighting.observation.target_enu_m == pytest.approx(TARGET.position_enu_m, abs=0.6)
        assert sighting.observation.masks is not None
        assert sighting.observation.masks.marked.any(axis=(1, 2))[sighting.observation.fitness > 0].all()
    # What imaging marks lies where the target is: most of it within a pixel of the truth.
    grown = np.stack([np.roll(exact.unoccluded, shift, axis) for shift in (-2, 0, 2) for axis in (0, 1)]).any(axis=0)
    assert np.count_nonzero(imaged.seen & grown) > 0.8 * np.count_nonzero(imaged.seen)


def test_neither_sees_what_is_out_of_the_image(forest: World) -> None:
    far_m = positions_m(0) + np.array([40.0, 0.0, 0.0])
    for fidelity in Fidelity:
        sensor = make_sensor(forest, dataclasses.replace(SCENARIO, fidelity=fidelity))
        sighting = sensor.sense(far_m, dataclasses.replace(TARGET, posture=Posture.LYING), np.random.default_rng(0))
        assert sighting.visibility == sighting.area_m2 == sighting.unoccluded_m2 == 0.0
        assert not sighting.observation.target_in_view


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_both_rank_strategies_alike() -> None:
    choices = parse_strategies("aos-pso,aos-pso(c4_m=9),blind-parallel")
    grid_s = np.arange(2.0, SCENARIO.duration_s, 0.25)
    visibility = np.empty((3, len(choices), len(Fidelity)))
    for row, initialisation in enumerate(draw_initialisations(len(visibility), 77, SCENARIO)):
        world = open_world(initialisation, SCENARIO)
        for column, choice in enumerate(choices):
            for layer, fidelity in enumerate(Fidelity):
                scenario = dataclasses.replace(SCENARIO, fidelity=fidelity)
                rows = list(run_strategy(world, scenario, initialisation, choice.make(), choice.label))
                curve = np.interp(grid_s, [step.time_s for step in rows], [step.visibility for step in rows])
                visibility[row, column, layer] = curve.mean()
    geometric, imaging = np.moveaxis(visibility, -1, 0)
    order = np.argsort(geometric.mean(axis=0)).tolist()
    assert np.argsort(imaging.mean(axis=0)).tolist() == order == [2, 1, 0]
    assert np.corrcoef(geometric.ravel(), imaging.ravel())[0, 1] > 0.8
