"""A run, step by step, in worlds of which everything is known; and what its time models charge."""

import dataclasses

import numpy as np
import pytest

from aos_gcs.imaging.model import LeaderCriterion
from aos_gcs.lab.experiment import closest_approach_m, run_strategy
from aos_gcs.lab.initialisation import paper_initialisations
from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.scenario import Scenario, TimeModel
from aos_gcs.lab.sensing import GeometricSensor
from aos_gcs.lab.strategies import parse_strategies
from aos_gcs.lab.tables import SCHEMA, to_table
from aos_gcs.lab.timing import rest_to_rest_s, step_duration_s
from aos_gcs.lab.worlds import Target
from aos_sim.errors.wind import Wind
from aos_sim.vehicle.dynamics import AirframeLimits, Guidance, SwarmState, step
from tests.fakes.lab_world import FakeWorld

START = paper_initialisations()[0]


def fly(scenario: Scenario, world: FakeWorld, text: str = "aos-apso-paper") -> list[StepRow]:
    (choice,) = parse_strategies(text)
    return list(run_strategy(world, scenario, START, choice.make(), choice.label))


def test_the_same_run_gives_the_same_rows() -> None:
    scenario = Scenario(duration_s=6.0)
    first, second = fly(scenario, FakeWorld()), fly(scenario, FakeWorld())
    assert first == second
    assert first[0].time_s == 0.0
    assert first[-1].time_s <= 6.0
    assert [row.step for row in first] == list(range(1, len(first) + 1))


def test_the_swarm_scans_until_the_target_is_in_view() -> None:
    rows = fly(Scenario(duration_s=6.0), FakeWorld(reach_m=16.0))
    branches = [row.branch for row in rows]
    found = branches.index("pso")
    assert found > 3
    assert set(branches[:found]) == {"line"}
    assert not any(row.in_view for row in rows[:found])
    assert rows[found].visibility == pytest.approx(0.5)
    assert rows[found].target_error_m == pytest.approx(0.25, abs=0.08)


def test_rows_count_ways_and_times_as_flown() -> None:
    rows = fly(Scenario(duration_s=6.0), FakeWorld())
    positions_m = np.array([[row.east_m, row.north_m] for row in rows])
    ways_m = np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    assert np.diff([row.path_m for row in rows]) == pytest.approx(ways_m.mean(axis=1))
    assert np.diff([row.time_s for row in rows]) == pytest.approx(np.maximum(ways_m.max(axis=1) / 10.0, 0.1))
    assert all(row.min_flight_distance_m <= row.min_distance_m + 1e-9 for row in rows)


def test_history_only_ever_adds() -> None:
    rng = np.random.default_rng(0)
    rows = fly(Scenario(duration_s=6.0), FakeWorld(seen=lambda _: rng.uniform(0.0, 0.6)))
    areas_m2 = [row.history_area_m2 for row in rows]
    assert areas_m2 == sorted(areas_m2)
    assert all(row.history_area_m2 >= row.area_m2 for row in rows)
    assert all(0.0 <= row.visibility <= 1.0 for row in rows)


def test_rows_become_a_table_of_the_schema() -> None:
    rows = fly(Scenario(duration_s=2.0), FakeWorld())
    table = to_table(rows)
    assert table.schema == SCHEMA
    assert table.to_pylist() == [dataclasses.asdict(row) for row in rows]


@pytest.mark.parametrize(("criterion", "leader"), [(LeaderCriterion.CONTRIBUTION, 3), (LeaderCriterion.INTEGRAL, 1)])
def test_who_leads(criterion: LeaderCriterion, leader: int) -> None:
    """The vehicle that sees most leads by contribution; by the integral the lowest one, whose pixels are finest."""
    scenario = Scenario(drones=3, leader_criterion=criterion)
    shares = {0.0: 0.2, 2.0: 0.3, 4.0: 0.8}
    sensor = GeometricSensor(FakeWorld(seen=lambda offset_m: shares[float(offset_m[0])]), scenario)
    positions_m = np.array([[0.0, 0.0, 35.0], [2.0, 0.0, 36.0], [4.0, 0.0, 37.0]])
    sighting = sensor.sense(positions_m, Target((0.0, 0.0)), np.random.default_rng(0))
    assert sighting.observation.leader_id == leader
    assert sighting.area_m2 == pytest.approx(0.8)
    assert sighting.visibility == pytest.approx(0.8)
    assert sighting.observation.masks is not None
    assert sighting.observation.masks.marked.sum(axis=(1, 2)).tolist() == [20, 30, 80]
    assert sighting.observation.heights_m is not None
    assert sighting.observation.heights_m.tolist() == [35.0, 36.0, 37.0]


def test_below_the_threshold_there_is_no_target() -> None:
    sensor = GeometricSensor(FakeWorld(seen=lambda _: 0.1), Scenario(drones=2))
    sighting = sensor.sense(
        np.array([[0.0, 0.0, 35.0], [4.0, 0.0, 36.0]]), Target((0.0, 0.0)), np.random.default_rng(0)
    )
    assert sighting.visibility == pytest.approx(0.1)
    assert not sighting.observation.target_in_view
    assert sighting.observation.target_enu_m is None
    assert sighting.observation.masks is None


def test_drones_that_cross_come_closer_in_flight_than_at_the_ends() -> None:
    start_m, end_m = np.array([[0.0, 0.0], [4.0, 0.0]]), np.array([[4.0, 3.0], [0.0, 3.0]])
    assert closest_approach_m(start_m, end_m) == pytest.approx(0.0)
    assert closest_approach_m(start_m, start_m) == pytest.approx(4.0)
    assert closest_approach_m(start_m, start_m + np.array([1.0, 2.0])) == pytest.approx(4.0)


def test_what_a_step_costs() -> None:
    moves_m = np.array([[3.0, 4.0], [1.0, 0.0]])
    paper = Scenario()
    assert step_duration_s(moves_m, paper) == pytest.approx(0.5)
    assert step_duration_s(np.zeros((2, 2)), paper) == paper.min_step_s
    dynamics = Scenario(time_model=TimeModel.DYNAMICS, processing_s=0.4)
    assert step_duration_s(moves_m, dynamics) == pytest.approx(0.4 + rest_to_rest_s(5.0, 10.0, 3.5))


@pytest.mark.parametrize("distance_m", [1.0, 2.0, 4.0, 60.0])
def test_flights_take_as_long_as_in_the_simulator(distance_m: float) -> None:
    state = SwarmState.at_rest(np.array([[0.0, 0.0, 35.0]]), np.zeros(1))
    guidance = Guidance(
        lifting=np.ones(1, bool),
        target_enu_m=np.array([[distance_m, 0.0, 35.0]]),
        speed_mps=np.full(1, 10.0),
        climb_mps=np.full(1, 3.0),
        descent_mps=np.full(1, 2.0),
        heading_rad=np.zeros(1),
    )
    time_s, rng = 0.0, np.random.default_rng(0)
    while distance_m - state.position_enu_m[0, 0] > 0.1:
        state = step(state, guidance, 0.02, limits=AirframeLimits(), wind=Wind(), rng=rng)
        time_s += 0.02
    assert rest_to_rest_s(distance_m, 10.0, 3.5) == pytest.approx(time_s, rel=0.2)
