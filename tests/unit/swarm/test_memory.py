"""Personal bests and sampled spots: what is remembered, how long, and what it changes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.swarm.aos_pso import make_aos_pso
from aos_gcs.swarm.memory import MAX_SAMPLED, clear_of_sampled
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.state import PersonalBest, SwarmState

FloatArray = NDArray[np.float64]
NORTH = np.array([0.0, 1.0])
APART = np.array([[0.0, 0.0], [200.0, 0.0], [0.0, 200.0]])
"""So far apart that repulsion does nothing."""


def seen(positions: FloatArray, fitness: list[float], *, in_view: bool = True) -> Observation:
    n = len(positions)
    return Observation(tuple(range(1, n + 1)), positions, np.array(fitness), in_view, NORTH if in_view else None)


def told(*observations: Observation, **parameters: object) -> SwarmState:
    strategy = make_aos_pso(parameters)
    state = strategy.init(NORTH)
    for observation in observations:
        state = strategy.tell(state, observation)
    return state


def test_personal_bests_are_kept_per_vehicle_and_a_missing_frame_changes_none() -> None:
    state = told(seen(APART, [1.0, 5.0, np.nan]), seen(APART + 1.0, [2.0, 4.0, np.nan]), personal_best_memory=True)
    assert state.personal_bests == (PersonalBest(1, (1.0, 1.0), 2.0), PersonalBest(2, (200.0, 0.0), 5.0))


def test_a_loss_forgets() -> None:
    lost = seen(APART, [0.0, 0.0, 0.0], in_view=False)
    state = told(seen(APART, [1.0, 2.0, 3.0]), lost, personal_best_memory=True, revisit_radius_m=1.0)
    assert (state.personal_bests, state.sampled_enu_m) == ((), ())


def test_nothing_is_remembered_unless_asked_for() -> None:
    state = told(seen(APART, [1.0, 2.0, 3.0]))
    assert (state.personal_bests, state.sampled_enu_m) == ((), ())


def test_sampled_spots_are_bounded_in_number() -> None:
    state = told(*[seen(APART + step, [1.0, 2.0, 3.0]) for step in range(140)], revisit_radius_m=1.0)
    assert len(state.sampled_enu_m) == MAX_SAMPLED
    assert state.sampled_enu_m[-3:] == ((139.0, 139.0), (339.0, 139.0), (139.0, 339.0))


def test_the_cognitive_term_points_to_the_personal_best() -> None:
    """Without attraction to the leader, which is itself far away, the way home shows in most draws."""
    strategy = make_aos_pso({"personal_best_memory": True, "c_s_m": 1.001, "c_c_m": 1.0})
    away = APART + np.array([30.0, 0.0])
    state = strategy.tell(strategy.init(NORTH), seen(APART, [9.0, 8.0, 7.0]))
    state = strategy.tell(state, seen(away, [1.0, 0.5, 0.5]))
    steps = np.array([strategy.ask(state, np.random.default_rng(seed))[0][0] - away[0] for seed in range(200)])
    # The leader's own step is the cognitive term: of length c_c, towards the ball around its best in the west.
    assert np.linalg.norm(steps, axis=1) == pytest.approx(np.ones(200), abs=0.01)
    assert steps[:, 0].max() < 0.05
    assert steps.mean(axis=0)[0] < -0.8
    assert abs(steps.mean(axis=0)[1]) < 0.1


def test_at_its_best_a_drone_moves_as_published() -> None:
    here = seen(APART, [9.0, 8.0, 7.0])
    moved = [
        strategy.ask(strategy.tell(strategy.init(NORTH), here), np.random.default_rng(3))[0]
        for strategy in (make_aos_pso({}), make_aos_pso({"personal_best_memory": True}))
    ]
    assert moved[0] == pytest.approx(moved[1])


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.2, 2.0))
def test_no_waypoint_lies_on_a_sampled_spot(seed: int, radius_m: float) -> None:
    rng = np.random.default_rng(seed)
    sampled = rng.uniform(0.0, 40.0, (60, 2))
    positions = 8.0 * np.stack(np.meshgrid(np.arange(3.0), np.arange(3.0)), axis=-1).reshape(-1, 2)
    moved = clear_of_sampled(positions, sampled, radius_m, 2.0, rng)
    clearances = np.linalg.norm(moved[:, None] - sampled[None, :], axis=2).min(axis=1)
    assert (clearances >= radius_m * (1.0 - 1e-9)).all()
    untouched = np.linalg.norm(positions[:, None] - sampled[None, :], axis=2).min(axis=1) >= radius_m
    assert np.array_equal(moved[untouched], positions[untouched])
    assert np.linalg.norm(moved - positions, axis=1).max() <= 4.0 * radius_m + 1e-9


def test_where_no_spot_is_free_the_best_one_is_taken() -> None:
    grid = 0.5 * np.stack(np.meshgrid(np.arange(-20.0, 21.0), np.arange(-20.0, 21.0)), axis=-1).reshape(-1, 2)
    moved = clear_of_sampled(np.array([[0.0, 0.0], [30.0, 0.0]]), grid, 1.0, 2.0, np.random.default_rng(0))
    assert 0.0 < np.linalg.norm(moved[0]) <= 4.0
    assert np.array_equal(moved[1], [30.0, 0.0])


def test_the_swarm_never_samples_a_spot_twice() -> None:
    strategy, rng = make_aos_pso({"revisit_radius_m": 0.5}), np.random.default_rng(2)
    positions, state, sampled = APART / 50.0, strategy.init(NORTH), np.empty((0, 2))
    for _ in range(15):
        observation = seen(positions, [3.0, 2.0, 1.0])
        if len(sampled):
            assert np.linalg.norm(positions[:, None] - sampled[None, :], axis=2).min() >= 0.5 * (1.0 - 1e-9)
        sampled = np.vstack([sampled, positions])
        positions, state = strategy.ask(strategy.tell(state, observation), rng)
