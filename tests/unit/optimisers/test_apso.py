"""APSO: evolutionary factor, fuzzy states, adaptation of the factors, elitist learning."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from aos_gcs.optimisers.apso import Apso, ApsoState
from aos_gcs.optimisers.evolution import (
    EvolutionaryState,
    adapted_factors,
    draw_delta,
    evolutionary_factor,
    fuzzy_state,
    inertia_weight,
    kept_in_sequence,
    memberships,
)

FloatArray = NDArray[np.float64]
EXPLORATION, EXPLOITATION, CONVERGENCE, JUMPING_OUT = EvolutionaryState


def test_factor_of_three_particles_in_a_row() -> None:
    # Mean distances to the others: (1 + 4) / 2 = 2.5, (1 + 3) / 2 = 2, (3 + 4) / 2 = 3.5.
    row = np.array([[0.0, 0.0], [1.0, 0.0], [4.0, 0.0]])
    assert evolutionary_factor(row, 0) == pytest.approx((2.5 - 2.0) / 1.5)
    assert evolutionary_factor(row, 1) == 0.0
    assert evolutionary_factor(row, 2) == 1.0


def test_factor_is_zero_where_all_are_equally_central() -> None:
    assert evolutionary_factor(np.array([[0.0, 0.0], [3.0, 4.0]]), 1) == 0.0
    assert evolutionary_factor(np.zeros((5, 2)), 2) == 0.0


@given(
    st.integers(2, 8).flatmap(lambda n: arrays(np.float64, (n, 2), elements=st.floats(-1e3, 1e3))), st.integers(0, 1)
)
def test_factor_lies_between_0_and_1(positions: FloatArray, leader: int) -> None:
    assert 0.0 <= evolutionary_factor(positions, leader) <= 1.0


def published_memberships(f: float) -> tuple[float, ...]:
    """The published piecewise functions, in the order of the states."""
    exploration = 5 * f - 2 if 0.4 < f <= 0.6 else 1.0 if 0.6 < f <= 0.7 else -10 * f + 8 if 0.7 < f <= 0.8 else 0.0
    exploitation = 10 * f - 2 if 0.2 < f <= 0.3 else 1.0 if 0.3 < f <= 0.4 else -5 * f + 3 if 0.4 < f <= 0.6 else 0.0
    convergence = 1.0 if f <= 0.1 else -5 * f + 1.5 if f <= 0.3 else 0.0
    jumping_out = 0.0 if f <= 0.7 else 5 * f - 3.5 if f <= 0.9 else 1.0
    return exploration, exploitation, convergence, jumping_out


@given(st.floats(0.0, 1.0))
def test_memberships_are_the_published_ones(e_f: float) -> None:
    assert tuple(memberships(e_f).values()) == pytest.approx(published_memberships(e_f), abs=1e-12)


@pytest.mark.parametrize(
    ("e_f", "states"),
    [
        (0.0, {CONVERGENCE}),
        (0.2, {CONVERGENCE}),
        (0.25, {CONVERGENCE, EXPLOITATION}),
        (0.3, {EXPLOITATION}),
        (0.4, {EXPLOITATION}),
        (0.5, {EXPLOITATION, EXPLORATION}),
        (0.6, {EXPLORATION}),
        (0.7, {EXPLORATION}),
        (0.75, {EXPLORATION, JUMPING_OUT}),
        (0.8, {JUMPING_OUT}),
        (1.0, {JUMPING_OUT}),
    ],
)
def test_states_that_apply(e_f: float, states: set[EvolutionaryState]) -> None:
    assert {fuzzy_state(e_f, previous) for previous in EvolutionaryState} == states


@pytest.mark.parametrize(
    ("e_f", "expected"),
    [
        (0.25, [EXPLOITATION, EXPLOITATION, CONVERGENCE, CONVERGENCE]),
        (0.5, [EXPLORATION, EXPLOITATION, EXPLOITATION, EXPLORATION]),
        (0.75, [EXPLORATION, EXPLORATION, JUMPING_OUT, JUMPING_OUT]),
    ],
)
def test_the_previous_state_decides(e_f: float, expected: list[EvolutionaryState]) -> None:
    assert [fuzzy_state(e_f, previous) for previous in EvolutionaryState] == expected


@given(st.sampled_from(EvolutionaryState), st.sampled_from(EvolutionaryState))
def test_the_order_of_the_two_states_does_not_matter(one: EvolutionaryState, previous: EvolutionaryState) -> None:
    sequence = list(EvolutionaryState)
    other = sequence[(sequence.index(one) + 1) % 4]
    assert kept_in_sequence(one, other, previous) is kept_in_sequence(other, one, previous)


@pytest.mark.parametrize(
    ("state", "c_c", "c_s"),
    [(EXPLORATION, 1.9, 1.7), (EXPLOITATION, 1.85, 1.75), (CONVERGENCE, 1.85, 1.85), (JUMPING_OUT, 1.7, 1.9)],
)
def test_directions_per_state(state: EvolutionaryState, c_c: float, c_s: float) -> None:
    assert adapted_factors(1.8, 1.8, state, delta=0.1) == pytest.approx((c_c, c_s))


def test_factors_are_clamped_and_scaled() -> None:
    assert adapted_factors(2.48, 1.5, EXPLORATION, 0.1) == pytest.approx((2.5, 1.5))
    assert adapted_factors(2.5, 2.5, CONVERGENCE, 0.1) == pytest.approx((2.0, 2.0))


@given(st.floats(1.5, 2.5), st.floats(1.5, 2.5), st.sampled_from(EvolutionaryState), st.floats(0.05, 0.1))
def test_factors_stay_in_their_limits(c_c: float, c_s: float, state: EvolutionaryState, delta: float) -> None:
    adapted = adapted_factors(c_c, c_s, state, delta)
    assert sum(adapted) <= 4.0 + 1e-12
    assert all(1.5 - 1e-12 <= factor <= 2.5 for factor in adapted)


def test_inertia_runs_from_0_4_to_0_9() -> None:
    assert inertia_weight(0.0) == pytest.approx(0.4)
    assert inertia_weight(1.0) == pytest.approx(1.0 / (1.0 + 1.5 * math.exp(-2.6)))
    assert inertia_weight(1.0) == pytest.approx(0.9, abs=0.003)


def test_acceleration_rates() -> None:
    rng = np.random.default_rng(0)
    rates = [draw_delta(rng) for _ in range(500)]
    assert 0.05 <= min(rates) < 0.052
    assert 0.098 < max(rates) < 0.1


def converging(elite_value: float) -> tuple[ApsoState, FloatArray]:
    """Tell a swarm about its best in the centre until it offers an elite; return what then becomes of the elite."""
    apso = Apso(lower=-10.0, upper=10.0, moves=100)
    ring = np.array([[0.1, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 2.0], [0.0, -2.0]])
    rng, state = np.random.default_rng(0), apso.init(ring)
    _, state = apso.ask(state, rng)
    state = apso.tell(state, np.array([1.0, 4.0, 4.0, 4.0, 9.0]))
    positions, state = apso.ask(state, rng)
    assert (state.e_f, state.evolutionary_state) == (0.0, CONVERGENCE)
    assert positions.shape == (6, 2)
    return apso.tell(state, np.array([5.0, 5.0, 5.0, 8.0, np.nan, elite_value])), positions[5]


def test_the_elite_differs_from_the_best_in_one_dimension() -> None:
    _, elite = converging(0.5)
    assert np.count_nonzero(elite != np.array([0.1, 0.0])) == 1
    assert np.abs(elite).max() <= 10.0


def test_a_better_elite_is_the_global_best() -> None:
    state, elite = converging(0.5)
    assert state.particles.best_value == 0.5
    assert np.array_equal(state.particles.best_position, elite)
    assert state.elite is None


@pytest.mark.parametrize("elite_value", [2.0, np.nan])
def test_another_elite_replaces_the_worst_particle(elite_value: float) -> None:
    state, elite = converging(elite_value)
    assert state.particles.best_value == 1.0
    # The last one has no value at all.
    assert np.array_equal(state.particles.positions[4], elite)
    assert not (state.particles.positions[:4] == elite).all(axis=1).any()


def test_velocities_are_limited_to_a_fifth_of_the_range() -> None:
    apso = Apso(lower=-1.0, upper=1.0, moves=50)
    rng = np.random.default_rng(1)
    state = apso.init(rng.uniform(-1.0, 1.0, (10, 3)))
    for _ in range(30):
        positions, state = apso.ask(state, rng)
        assert np.abs(state.particles.velocities).max() <= 0.4 + 1e-12
        state = apso.tell(state, (positions**2).sum(axis=1))


def test_the_elite_leaves_a_local_optimum() -> None:
    # Two basins far apart; the swarm starts in the worse one, where particles alone would stay.
    def value(x: FloatArray) -> FloatArray:
        here, there = np.abs(x - 3.0).max(axis=1), np.abs(x + 3.0).max(axis=1)
        return np.asarray(np.minimum(here + 1.0, 4.0 * there))

    def objective(x: FloatArray) -> FloatArray:
        return np.asarray(sum(value(x[:, [column]]) for column in range(x.shape[1])))

    apso, rng = Apso(lower=-5.0, upper=5.0, moves=200), np.random.default_rng(4)
    state = apso.init(rng.uniform(2.5, 3.5, (12, 2)))
    for _ in range(200):
        positions, state = apso.ask(state, rng)
        state = apso.tell(state, objective(positions))
    position, best = apso.best(state)
    assert position == pytest.approx([-3.0, -3.0], abs=0.1)
    assert best < 1.0
