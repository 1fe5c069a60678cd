"""State table and adaptation of AOS-APSO, against hand-computed values."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.optimisers.evolution import EvolutionaryState
from aos_gcs.swarm.evolution import FractionalFactors, adapt, decrease, increase, next_state, normalise

EXPLORATION, EXPLOITATION, CONVERGENCE, JUMPING_OUT = EvolutionaryState
fractions = st.floats(1e-6, 1.0 - 1e-6)
gammas = st.floats(0.01, 0.99)


@pytest.mark.parametrize(
    ("e_f", "previous", "expected"),
    [
        (0.0, JUMPING_OUT, CONVERGENCE),
        (math.nextafter(0.025, 0), EXPLOITATION, CONVERGENCE),
        (0.025, EXPLOITATION, EXPLOITATION),
        (0.025, EXPLORATION, EXPLOITATION),
        (0.025, CONVERGENCE, CONVERGENCE),
        (0.025, JUMPING_OUT, CONVERGENCE),
        (math.nextafter(0.1, 0), CONVERGENCE, CONVERGENCE),
        (0.1, CONVERGENCE, EXPLOITATION),
        (math.nextafter(0.15, 0), JUMPING_OUT, EXPLOITATION),
        (0.15, EXPLORATION, EXPLORATION),
        (0.15, JUMPING_OUT, EXPLORATION),
        (0.15, EXPLOITATION, EXPLOITATION),
        (0.15, CONVERGENCE, EXPLOITATION),
        (math.nextafter(0.25, 0), CONVERGENCE, EXPLOITATION),
        (0.25, CONVERGENCE, EXPLORATION),
        (math.nextafter(0.5, 0), JUMPING_OUT, EXPLORATION),
        (0.5, JUMPING_OUT, JUMPING_OUT),
        (0.5, CONVERGENCE, JUMPING_OUT),
        (0.5, EXPLORATION, EXPLORATION),
        (0.5, EXPLOITATION, EXPLORATION),
        (math.nextafter(0.6, 0), EXPLOITATION, EXPLORATION),
        (0.6, EXPLORATION, JUMPING_OUT),
        (1.0, CONVERGENCE, JUMPING_OUT),
    ],
)
def test_state_table(e_f: float, previous: EvolutionaryState, expected: EvolutionaryState) -> None:
    assert next_state(e_f, previous) is expected


def test_increase_and_decrease_by_hand() -> None:
    assert increase(0.5, 0.9) == pytest.approx(0.55)
    assert decrease(0.5, 0.9) == pytest.approx(0.45)


@given(fractions, gammas)
def test_increase_and_decrease_stay_inside_and_move_the_right_way(factor: float, gamma: float) -> None:
    assert 0.0 < decrease(factor, gamma) < factor < increase(factor, gamma) < 1.0


@pytest.mark.parametrize(
    ("state", "c_s_hat", "c_c_hat"),
    [(EXPLORATION, 0.45, 0.55), (EXPLOITATION, 0.475, 0.525), (CONVERGENCE, 0.525, 0.525), (JUMPING_OUT, 0.55, 0.45)],
)
def test_directions_per_state(state: EvolutionaryState, c_s_hat: float, c_c_hat: float) -> None:
    adapted = adapt(FractionalFactors(0.5, 0.5), state, gamma=0.9)
    assert (adapted.c_s_hat, adapted.c_c_hat) == pytest.approx((c_s_hat, c_c_hat))


def test_normalisation_scales_both_factors_alike() -> None:
    normalised = normalise(FractionalFactors(0.9, 0.6))
    assert normalised.c_s_hat * (1.0 + normalised.c_c_hat) == pytest.approx(1.0)
    assert normalised.c_s_hat / normalised.c_c_hat == pytest.approx(1.5)
    assert normalise(FractionalFactors(0.5, 0.9)) == FractionalFactors(0.5, 0.9)


@given(fractions, fractions, st.sampled_from(EvolutionaryState), gammas, st.integers(1, 400))
def test_constraints_hold_however_long_a_state_lasts(
    c_s_hat: float, c_c_hat: float, state: EvolutionaryState, gamma: float, steps: int
) -> None:
    factors = FractionalFactors(c_s_hat, c_c_hat)
    for _ in range(steps):
        factors = adapt(factors, state, gamma)
    c_s_m, c_c_m = factors.c_s_m(4.2), factors.c_c_m(4.2)
    assert 0.0 < factors.c_s_hat < 1.0
    assert 0.0 < factors.c_c_hat < 1.0
    assert c_s_m > c_c_m > 0.0
    assert c_s_m + c_c_m <= 4.2 * (1.0 + 1e-12)


def test_bounds_stop_the_decay() -> None:
    factors = FractionalFactors(0.5, 0.5)
    for _ in range(100):
        factors = adapt(factors, EXPLORATION, 0.9, minimum=0.25, maximum=0.8)
    assert factors == FractionalFactors(0.25, 0.8)


def test_published_factors_are_the_exact_equivalent() -> None:
    factors = FractionalFactors(2.0 / 4.2, 0.5)
    assert factors.c_s_m(4.2) == pytest.approx(2.0)
    assert factors.c_c_m(4.2) == pytest.approx(1.0)
