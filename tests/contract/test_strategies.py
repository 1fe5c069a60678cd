"""What every registered strategy promises, whoever wrote it."""

import json
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.swarm.model import Observation, Strategy
from aos_gcs.swarm.registry import available_strategies, make_strategy
from aos_gcs.swarm.state import dump_rng, dump_state, load_rng, load_state

FloatArray = NDArray[np.float64]
NORTH = np.array([0.0, 1.0])
TARGET = np.array([3.0, 25.0])


@pytest.fixture(params=available_strategies())
def strategy(request: pytest.FixtureRequest) -> Strategy[Any]:
    return make_strategy(request.param, {})


def observe(
    positions: FloatArray,
    *,
    ids: Iterable[int] | None = None,
    in_view: bool | None = None,
    leader_id: int | None = None,
) -> Observation:
    """A smooth field about TARGET; in view within 12 m."""
    distances = np.linalg.norm(positions - TARGET, axis=1)
    visible = bool(distances.min() < 12.0) if in_view is None else in_view
    return Observation(
        vehicle_ids=tuple(range(1, len(positions) + 1) if ids is None else ids),
        positions_enu_m=positions,
        fitness=np.exp(-distances / 10.0),
        target_in_view=visible,
        target_enu_m=TARGET if visible else None,
        leader_id=leader_id,
    )


def line_of(n: int, north_m: float = 0.0) -> FloatArray:
    return np.column_stack([4.2 * (np.arange(n) - (n - 1) / 2), np.full(n, north_m)])


def fly(strategy: Strategy[Any], seed: int, steps: int, n: int = 10) -> FloatArray:
    rng, state, positions = np.random.default_rng(seed), strategy.init(NORTH), line_of(n)
    trajectory = [positions]
    for _ in range(steps):
        state = strategy.tell(state, observe(positions))
        positions, state = strategy.ask(state, rng)
        trajectory.append(positions)
    return np.array(trajectory)


def test_has_its_name_and_a_spacing(strategy: Strategy[Any]) -> None:
    assert strategy.name in available_strategies()
    assert strategy.spacing_m > 0.0


def test_same_seed_same_trajectory(strategy: Strategy[Any]) -> None:
    first = fly(strategy, seed=5, steps=30)
    assert np.array_equal(first, fly(strategy, seed=5, steps=30))
    assert not np.array_equal(first, fly(strategy, seed=6, steps=30))


def test_state_and_generator_survive_json_in_mid_run(strategy: Strategy[Any]) -> None:
    rng, state, positions = np.random.default_rng(9), strategy.init(NORTH), line_of(10)
    for step in range(24):
        state = strategy.tell(state, observe(positions))
        saved_state, saved_rng = json.dumps(dump_state(state)), json.dumps(dump_rng(rng))
        positions, state = strategy.ask(state, rng)
        loaded, loaded_rng = load_state(json.loads(saved_state)), load_rng(json.loads(saved_rng))
        again, state_again = strategy.ask(loaded, loaded_rng)
        assert np.array_equal(positions, again), f"step {step}"
        assert state == state_again
        assert rng.bit_generator.state == loaded_rng.bit_generator.state
        assert strategy.diagnostics(state) == strategy.diagnostics(state_again)


@pytest.mark.parametrize("n", [2, 3, 10, 25])
def test_constraints_hold_and_positions_are_finite_at_each_step(strategy: Strategy[Any], n: int) -> None:
    rng, state, positions = np.random.default_rng(2), strategy.init(NORTH), line_of(n)
    branches = set()
    for _ in range(40):
        state = strategy.tell(state, observe(positions))
        positions, state = strategy.ask(state, rng)
        diagnostics = strategy.diagnostics(state)
        branches.add(diagnostics.branch)
        assert positions.shape == (n, 2)
        assert np.isfinite(positions).all()
        if diagnostics.c_s_m is not None and diagnostics.c_c_m is not None:
            assert diagnostics.c_s_m > diagnostics.c_c_m > 0.0
            assert diagnostics.c_s_m + diagnostics.c_c_m <= strategy.spacing_m * (1.0 + 1e-12)
        if diagnostics.evolutionary_factor is not None:
            assert 0.0 <= diagnostics.evolutionary_factor <= 1.0
    assert branches == {"line", "pso"}


def test_vehicles_leave_and_join(strategy: Strategy[Any]) -> None:
    rng, state, positions = np.random.default_rng(1), strategy.init(NORTH), line_of(10, north_m=20.0)
    for ids in ([1, 2, 3, 4, 5], [1, 3, 5], [3, 5], [3, 5, 7, 9], [11, 12]):
        rows = [vehicle_id % 10 for vehicle_id in ids]
        state = strategy.tell(state, observe(positions[rows], ids=ids, in_view=True))
        moved, state = strategy.ask(state, rng)
        assert moved.shape == (len(ids), 2)
        assert np.isfinite(moved).all()
        assert strategy.diagnostics(state).leader_id in ids


def test_nan_never_leads(strategy: Strategy[Any]) -> None:
    near = observe(line_of(5, north_m=20.0))
    best = int(near.fitness.argmax())
    fitness = near.fitness.copy()
    fitness[best] = np.nan
    blind = replace(near, fitness=fitness, leader_id=near.vehicle_ids[best])
    state = strategy.tell(strategy.init(NORTH), blind)
    positions, state = strategy.ask(state, np.random.default_rng(0))
    expected = near.vehicle_ids[int(np.nanargmax(fitness))]
    assert strategy.diagnostics(state).leader_id == expected
    assert np.isfinite(positions).all()


def test_without_any_frame_the_line_goes_on(strategy: Strategy[Any]) -> None:
    dark = replace(observe(line_of(4), in_view=True), fitness=np.full(4, np.nan))
    positions, state = strategy.ask(strategy.tell(strategy.init(NORTH), dark), np.random.default_rng(0))
    assert strategy.diagnostics(state).branch == "line"
    assert strategy.diagnostics(state).leader_id is None
    assert np.isfinite(positions).all()


def test_the_choice_of_the_imaging_leads_unless_it_is_missing(strategy: Strategy[Any]) -> None:
    near = observe(line_of(5, north_m=20.0))
    for chosen, expected in ((2, 2), (99, near.vehicle_ids[int(near.fitness.argmax())])):
        state = strategy.tell(strategy.init(NORTH), replace(near, leader_id=chosen))
        _, state = strategy.ask(state, np.random.default_rng(0))
        assert strategy.diagnostics(state).leader_id == expected


@pytest.mark.parametrize("in_view", [False, True])
def test_coincident_drones(strategy: Strategy[Any], in_view: bool) -> None:
    rng, state = np.random.default_rng(0), strategy.init(NORTH)
    positions, state = strategy.ask(strategy.tell(state, observe(np.zeros((6, 2)), in_view=in_view)), rng)
    assert np.isfinite(positions).all()
    distances = np.linalg.norm(positions[:, None] - positions[None, :], axis=2)
    assert distances[np.triu_indices(6, k=1)].min() > 0.5


@pytest.mark.parametrize("in_view", [False, True])
def test_order_of_the_report_changes_nothing(strategy: Strategy[Any], in_view: bool) -> None:
    positions = line_of(6) + np.random.default_rng(3).normal(size=(6, 2))
    order = [3, 0, 5, 1, 4, 2]
    ids = np.arange(1, 7)
    results = []
    for rows in (list(range(6)), order):
        told = strategy.tell(strategy.init(NORTH), observe(positions[rows], ids=ids[rows].tolist(), in_view=in_view))
        results.append(strategy.ask(told, np.random.default_rng(8))[0])
    assert np.array_equal(results[0][order], results[1])


def test_arguments_are_left_alone(strategy: Strategy[Any]) -> None:
    observation = observe(line_of(5, north_m=20.0))
    positions, fitness = observation.positions_enu_m.copy(), observation.fitness.copy()
    strategy.ask(strategy.tell(strategy.init(NORTH), observation), np.random.default_rng(0))
    assert np.array_equal(observation.positions_enu_m, positions)
    assert np.array_equal(observation.fitness, fitness)


def test_ask_needs_tell(strategy: Strategy[Any]) -> None:
    rng, state = np.random.default_rng(0), strategy.init(NORTH)
    with pytest.raises(RuntimeError, match="tell"):
        strategy.ask(state, rng)
    _, state = strategy.ask(strategy.tell(state, observe(line_of(3))), rng)
    with pytest.raises(RuntimeError, match="tell"):
        strategy.ask(state, rng)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"vehicle_ids": (1,), "positions_enu_m": np.zeros((1, 2)), "fitness": np.zeros(1)}, "two or more"),
        ({"vehicle_ids": (1, 1, 2)}, "differ"),
        ({"positions_enu_m": np.zeros((3, 3))}, "shape"),
        ({"fitness": np.zeros(2)}, "shape"),
        ({"positions_enu_m": np.full((3, 2), np.nan)}, "finite"),
        ({"target_enu_m": np.array([np.nan, 0.0])}, "target"),
    ],
)
def test_observations_that_do_not_fit_are_refused(strategy: Strategy[Any], change: dict[str, Any], text: str) -> None:
    observation = observe(line_of(3), in_view=True)
    with pytest.raises(ValueError, match=text):
        strategy.tell(strategy.init(NORTH), replace(observation, **change))


def test_a_scanning_direction_without_length_is_refused(strategy: Strategy[Any]) -> None:
    with pytest.raises(ValueError, match="direction"):
        strategy.init(np.zeros(2))
