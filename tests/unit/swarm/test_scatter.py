"""Rutherford scattering: exact two-body motion, symmetries, leader stabilisation, cut-off, coincident drones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from aos_gcs.swarm.scatter import DURATION_S, scatter

C4 = 4.2
FloatArray = NDArray[np.float64]


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def swarms(max_n: int = 8) -> st.SearchStrategy[FloatArray]:
    """Positions on a jittered grid: no two drones closer than 0.5 m, the sizes and shapes vary."""

    @st.composite
    def build(draw: st.DrawFn) -> FloatArray:
        n = draw(st.integers(2, max_n))
        cells = draw(st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=n, max_size=n, unique=True))
        jitter = draw(arrays(np.float64, (n, 2), elements=st.floats(-0.5, 0.5)))
        return 1.5 * np.array(cells, dtype=np.float64) + jitter

    return build()


def energy(positions: FloatArray, leader: int | None = None) -> float:
    """What the motion descends: the sum of 1 / distance over pairs, pairs with a stabilised leader counted twice."""
    first, second = np.triu_indices(len(positions), k=1)
    weights = np.where((first == leader) | (second == leader), 2.0, 1.0)
    return float((weights / np.linalg.norm(positions[first] - positions[second], axis=1)).sum())


def exact(positions: FloatArray) -> FloatArray:
    """The equation of motion by an independent integrator with tight tolerances."""

    def velocity(_: float, flat: FloatArray) -> FloatArray:
        x = flat.reshape(-1, 2)
        d = x[:, None] - x[None, :]
        r = np.linalg.norm(d, axis=2) + np.diag(np.full(len(x), np.inf))
        return C4**2 * (d / r[..., None] ** 3).sum(axis=1).ravel()

    result = solve_ivp(velocity, (0.0, DURATION_S), positions.ravel(), rtol=1e-10, atol=1e-12)
    return np.asarray(result.y[:, -1]).reshape(-1, 2)


def published(positions: FloatArray) -> FloatArray:
    """The published integrator: 500 explicit steps over half a second."""
    x = positions.copy()
    for _ in range(500):
        d = x[:, None] - x[None, :]
        r = np.linalg.norm(d, axis=2) + np.diag(np.full(len(x), np.inf))
        x = x + DURATION_S / 500 * C4**2 * (d / r[..., None] ** 3).sum(axis=1)
    return x


@pytest.mark.parametrize("start_m", [0.2, 1.0, 4.2, 20.0])
def test_two_drones_follow_the_closed_form(start_m: float) -> None:
    # r' = 2 c4^2 / r^2 gives r^3 = r0^3 + 6 c4^2 t.
    moved = scatter(np.array([[0.0, 0.0], [start_m, 0.0]]), C4, rng())
    expected_m = (start_m**3 + 6.0 * C4**2 * DURATION_S) ** (1.0 / 3.0)
    assert np.linalg.norm(moved[1] - moved[0]) == pytest.approx(expected_m, abs=2e-3)
    assert moved[:, 1] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_agrees_with_an_independent_integrator() -> None:
    positions = np.random.default_rng(3).normal(scale=3.0, size=(10, 2))
    assert scatter(positions, C4, rng()) == pytest.approx(exact(positions), abs=3e-3)


def test_agrees_with_the_published_explicit_steps() -> None:
    cells = np.stack(np.meshgrid(np.arange(4), np.arange(3)), axis=-1).reshape(-1, 2)
    positions = 1.2 * cells + np.random.default_rng(4).uniform(-0.2, 0.2, (12, 2))
    assert scatter(positions, C4, rng()) == pytest.approx(published(positions), abs=0.02)


@settings(max_examples=40, deadline=None)
@given(swarms(), st.floats(-np.pi, np.pi), st.tuples(st.floats(-500, 500), st.floats(-500, 500)))
def test_rotation_and_translation_carry_over(positions: FloatArray, angle: float, shift: tuple[float, float]) -> None:
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = scatter(positions @ R.T + shift, C4, rng(), leader=0)
    assert moved == pytest.approx(scatter(positions, C4, rng(), leader=0) @ R.T + shift, abs=1e-6)


@settings(max_examples=40, deadline=None)
@given(swarms())
def test_centre_stays_without_a_stabilised_leader(positions: FloatArray) -> None:
    assert scatter(positions, C4, rng()).mean(axis=0) == pytest.approx(positions.mean(axis=0), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(swarms(), st.integers(0, 1))
def test_a_stabilised_leader_stays(positions: FloatArray, leader: int) -> None:
    assert np.array_equal(scatter(positions, C4, rng(), leader=leader)[leader], positions[leader])


@settings(max_examples=40, deadline=None)
@given(swarms(), st.booleans())
def test_energy_falls(positions: FloatArray, stabilised: bool) -> None:
    leader = 0 if stabilised else None
    assert energy(scatter(positions, C4, rng(), leader=leader), leader) < energy(positions, leader)


@settings(max_examples=40, deadline=None)
@given(swarms(max_n=3))
def test_the_smallest_distance_of_up_to_three_drones_grows(positions: FloatArray) -> None:
    def smallest(x: FloatArray) -> float:
        first, second = np.triu_indices(len(x), k=1)
        return float(np.linalg.norm(x[first] - x[second], axis=1).min())

    assert smallest(scatter(positions, C4, rng())) > smallest(positions)


def test_force_of_a_stabilised_leader_is_doubled() -> None:
    # Against a fixed leader of doubled force: r' = 2 c4^2 / r^2, as fast as two free drones part.
    moved = scatter(np.array([[0.0, 0.0], [3.0, 0.0]]), C4, rng(), leader=0)
    assert moved[1, 0] == pytest.approx((27.0 + 6.0 * C4**2 * DURATION_S) ** (1.0 / 3.0), abs=2e-3)


def test_beyond_the_cutoff_nothing_moves() -> None:
    positions = np.array([[0.0, 0.0], [5.0, 0.0]])
    assert np.array_equal(scatter(positions, C4, rng(), cutoff_m=5.0), positions)
    assert not np.array_equal(scatter(positions, C4, rng(), cutoff_m=5.1), positions)


@pytest.mark.parametrize("leader", [None, 0])
def test_coincident_drones_part(leader: int | None) -> None:
    positions = np.zeros((10, 2))
    moved = scatter(positions, C4, rng(), leader=leader)
    distances = np.linalg.norm(moved[:, None] - moved[None, :], axis=2) + np.diag(np.full(10, np.inf))
    assert np.isfinite(moved).all()
    assert distances.min() > 1.0
    assert np.array_equal(positions, np.zeros((10, 2)))
    if leader is None:
        assert moved.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    else:
        assert np.array_equal(moved[leader], [0.0, 0.0])


def test_nearly_coincident_drones_do_not_explode() -> None:
    moved = scatter(np.array([[0.0, 0.0], [1e-5, 0.0]]), C4, rng())
    assert np.linalg.norm(moved[1] - moved[0]) == pytest.approx((6.0 * C4**2 * DURATION_S) ** (1.0 / 3.0), abs=2e-3)
