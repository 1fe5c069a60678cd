"""PSO and CPSO: the update by hand, schedules, memory, rotation, repulsion, moving peaks."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.optimisers.apso import Apso
from aos_gcs.optimisers.cpso import Cpso, repulsion
from aos_gcs.optimisers.model import Optimiser, Particles, Schedule, forgetful
from aos_gcs.optimisers.pso import Pso, PsoParameters, drawn_velocities, moved
from aos_gcs.optimisers.randomness import Draw, Randomness, attraction, draw
from aos_gcs.store.codec import decode, encode
from aos_gcs.swarm.state import dump_rng
from tests.fakes.generators import load_rng

FloatArray = NDArray[np.float64]
Objective = Callable[[FloatArray], FloatArray]


def converging(max_velocity: Schedule | None = None, randomness: Randomness = Randomness.VECTOR) -> PsoParameters:
    """A setting with which PSO converges."""
    return PsoParameters(c_c=1.5, c_s=1.5, inertia=Schedule(0.73), max_velocity=max_velocity, randomness=randomness)


def sphere(x: FloatArray) -> FloatArray:
    return np.asarray((x**2).sum(axis=1))


def ellipsoid(x: FloatArray) -> FloatArray:
    return np.asarray((x**2 * np.arange(1.0, x.shape[1] + 1.0) ** 2).sum(axis=1))


def swarm(n: int, dim: int, seed: int = 0) -> FloatArray:
    return np.random.default_rng(seed).uniform(-5.0, 5.0, (n, dim))


def fly(optimiser: Optimiser[Any], start: FloatArray, objective: Objective, steps: int, seed: int = 0) -> Any:
    rng, state = np.random.default_rng(seed), optimiser.init(start)
    for _ in range(steps):
        positions, state = optimiser.ask(state, rng)
        state = optimiser.tell(state, objective(positions))
    return state


def test_one_update_by_hand() -> None:
    particles = Particles(
        positions=np.array([[0.0, 0.0], [4.0, 0.0]]),
        velocities=np.array([[1.0, 0.0], [0.0, -2.0]]),
        best_positions=np.array([[0.0, 2.0], [4.0, 4.0]]),
        best_values=np.array([1.0, 3.0]),
    )
    parameters = PsoParameters(c_c=2.0, c_s=1.0, inertia=Schedule(0.5))
    cognitive, social = Draw(np.array([[0.5, 0.25], [0.0, 0.5]])), Draw(np.array([[1.0, 0.5], [0.5, 0.0]]))
    velocities = drawn_velocities(particles, parameters, cognitive, social)
    # First: 0.5 (1, 0) + 2 (0.5 * 0, 0.25 * 2) + (0, 0.5 * 2); second: 0.5 (0, -2) + 2 (0, 0.5 * 4) + (0.5 * -4, 0).
    assert velocities == pytest.approx(np.array([[0.5, 2.0], [-2.0, 3.0]]))
    assert moved(particles, velocities, parameters).positions == pytest.approx(np.array([[0.5, 2.0], [2.0, 3.0]]))


def test_originally_nothing_damps_or_limits() -> None:
    parameters = PsoParameters()
    assert (parameters.c_c, parameters.c_s, parameters.inertia.at(0), parameters.inertia.at(99)) == (2.0, 2.0, 1.0, 1.0)
    assert parameters.max_velocity is None


def test_schedules_fall_linearly_and_then_stay() -> None:
    falling = Schedule(0.9, 0.4, steps=10)
    assert [falling.at(step) for step in (0, 5, 10, 99)] == pytest.approx([0.9, 0.65, 0.4, 0.4])
    with pytest.raises(ConfigurationError, match="steps"):
        Schedule(1.0, 0.5, steps=0)


@pytest.mark.parametrize("randomness", Randomness)
def test_a_shrinking_limit_holds_for_each_move(randomness: Randomness) -> None:
    limit = Schedule(1.0, 0.1, steps=8)
    optimiser = Pso(PsoParameters(max_velocity=limit, randomness=randomness))
    rng, state = np.random.default_rng(1), optimiser.init(swarm(20, 3))
    for _ in range(12):
        positions, asked = optimiser.ask(state, rng)
        bound = limit.at(state.moves) * (1.0 + 1e-12)
        if randomness is Randomness.VECTOR:
            assert np.abs(asked.velocities).max() <= bound
        else:
            assert np.linalg.norm(asked.velocities, axis=1).max() <= bound
        state = optimiser.tell(asked, sphere(positions))
    assert state.moves == 11


@given(st.integers(1, 5), st.integers(0, 99), st.sampled_from(Randomness))
def test_an_attraction_stays_in_its_region(dim: int, seed: int, randomness: Randomness) -> None:
    rng = np.random.default_rng(seed)
    offsets = rng.normal(size=(50, dim))
    pulls = attraction(offsets, draw(randomness, 50, dim, rng), exponent=3)
    if randomness is Randomness.SPHERICAL:
        lengths = np.linalg.norm(offsets, axis=1)
        assert (np.linalg.norm(pulls - offsets, axis=1) <= lengths * (1.0 + 1e-12)).all()
    else:
        shares = pulls / offsets
        assert ((shares >= 0.0) & (shares < 1.0)).all()
        if randomness is Randomness.SCALAR:
            assert shares == pytest.approx(np.repeat(shares[:, :1], dim, axis=1))


def test_the_exponent_gathers_points_about_the_attractor() -> None:
    drawn = draw(Randomness.SPHERICAL, 4000, 2, np.random.default_rng(0))
    offsets = np.tile([3.0, 4.0], (4000, 1))
    for exponent in (1, 3):
        radii = np.linalg.norm(attraction(offsets, drawn, exponent) - offsets, axis=1)
        # The mean of R^m is 1 / (m + 1).
        assert radii.mean() == pytest.approx(5.0 / (exponent + 1), rel=0.05)


def turned(drawn: Draw, rotation: FloatArray) -> Draw:
    """The same draws in the frame of a turned world: directions turn, numbers along axes have no other meaning."""
    return drawn if drawn.units is None else replace(drawn, units=drawn.units @ rotation.T)


def fly_in_both_worlds(randomness: Randomness, dim: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return the trajectory in a turned world and the turned trajectory, shape (steps, n, dim) each."""
    # A second to import, which only the process that runs these tests should pay.
    from scipy.stats import ortho_group  # noqa: PLC0415

    rotation = ortho_group.rvs(dim, random_state=seed)
    parameters = converging(Schedule(2.0), randomness)
    rng, start = np.random.default_rng(seed), swarm(12, dim, seed)
    optimiser = Pso(parameters)
    plain, world = optimiser.init(start), optimiser.init(start @ rotation.T)
    rows = []
    for _ in range(25):
        plain = optimiser.tell(replace(plain, awaits_tell=True), ellipsoid(plain.positions))
        world = optimiser.tell(replace(world, awaits_tell=True), ellipsoid(world.positions @ rotation))
        draws = [draw(randomness, 12, dim, rng) for _ in range(2)]
        plain = moved(plain, drawn_velocities(plain, parameters, *draws), parameters)
        world = moved(
            world, drawn_velocities(world, parameters, *(turned(drawn, rotation) for drawn in draws)), parameters
        )
        rows.append((world.positions, plain.positions @ rotation.T))
    in_world, carried_over = zip(*rows, strict=True)
    return np.array(in_world), np.array(carried_over)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from([Randomness.SCALAR, Randomness.SPHERICAL]), st.integers(2, 6), st.integers(0, 10_000))
def test_rotated_functions_give_rotated_trajectories(randomness: Randomness, dim: int, seed: int) -> None:
    in_world, carried_over = fly_in_both_worlds(randomness, dim, seed)
    assert in_world == pytest.approx(carried_over, abs=1e-7)


@settings(max_examples=25, deadline=None)
@given(st.integers(2, 6), st.integers(0, 10_000))
def test_the_vector_does_not_carry_over(dim: int, seed: int) -> None:
    in_world, carried_over = fly_in_both_worlds(Randomness.VECTOR, dim, seed)
    assert np.abs(in_world - carried_over).max() > 0.1


def test_no_draw_makes_the_vector_carry_over() -> None:
    # Towards (1, 1) it may reach (1, 0). An eighth of a turn makes that pull point to (0, sqrt 2) and reach
    # (0.71, 0.71), but a box along the axes is flat there: whatever is drawn, nothing moves along the first axis.
    rotation = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    offset = np.array([[1.0, 1.0]])
    reached = attraction(offset, Draw(np.array([[1.0, 0.0]])), exponent=1) @ rotation.T
    assert reached[0, 0] == pytest.approx(0.5**0.5)
    for R in np.random.default_rng(0).uniform(size=(100, 1, 2)):
        assert attraction(offset @ rotation.T, Draw(R), exponent=1)[0, 0] == pytest.approx(0.0, abs=1e-15)


def test_a_value_that_is_no_number_never_leads() -> None:
    optimiser = Pso()
    positions, state = optimiser.ask(optimiser.init(swarm(4, 2)), np.random.default_rng(0))
    state = optimiser.tell(state, np.array([np.nan, 3.0, np.nan, 5.0]))
    assert state.leader == 1
    assert np.array_equal(state.best_position, positions[1])
    assert state.best_value == 3.0
    assert np.isfinite(optimiser.ask(state, np.random.default_rng(0))[0]).all()


def test_the_search_goes_on_from_a_start_without_any_value() -> None:
    optimiser = Pso(PsoParameters(randomness=Randomness.SPHERICAL))
    state = fly(optimiser, swarm(4, 2), lambda x: np.full(len(x), np.nan), steps=3)
    assert state.moves == 2


def test_the_first_positions_asked_for_are_those_of_the_start() -> None:
    start = swarm(5, 3)
    positions, _ = Pso().ask(Pso().init(start), np.random.default_rng(0))
    assert np.array_equal(positions, start)


@pytest.mark.parametrize(
    "optimiser",
    [Pso(converging()), Cpso((0.3,) * 8, 2.0), Apso(lower=-5.0, upper=5.0, moves=30)],
    ids=["pso", "cpso", "apso"],
)
class TestEveryOptimiser:
    def test_order_and_shapes_are_checked(self, optimiser: Optimiser[Any]) -> None:
        rng, state = np.random.default_rng(0), optimiser.init(swarm(8, 2))
        with pytest.raises(RuntimeError, match="ask"):
            optimiser.tell(state, np.zeros(8))
        _, state = optimiser.ask(state, rng)
        with pytest.raises(RuntimeError, match="tell"):
            optimiser.ask(state, rng)
        with pytest.raises(ValueError, match=r"shape \(8,\)"):
            optimiser.tell(state, np.zeros(7))
        with pytest.raises(ValueError, match="shape"):
            optimiser.init(np.zeros((8, 2)), np.zeros((8, 3)))
        with pytest.raises(ValueError, match="finite"):
            optimiser.init(np.full((8, 2), np.inf))

    def test_a_saved_search_goes_on_bit_for_bit(self, optimiser: Optimiser[Any]) -> None:
        rng, state = np.random.default_rng(2), optimiser.init(swarm(8, 3))
        for _ in range(15):
            saved, saved_rng = json.dumps(encode(state)), json.dumps(dump_rng(rng))
            positions, asked = optimiser.ask(state, rng)
            again, asked_again = optimiser.ask(decode(type(state), json.loads(saved)), load_rng(json.loads(saved_rng)))
            assert np.array_equal(positions, again)
            state = optimiser.tell(asked, ellipsoid(positions))
            state_again = optimiser.tell(asked_again, ellipsoid(again))
            assert json.dumps(encode(state)) == json.dumps(encode(state_again))

    def test_the_best_never_gets_worse_and_is_what_was_evaluated(self, optimiser: Optimiser[Any]) -> None:
        rng, state, before = np.random.default_rng(3), optimiser.init(swarm(8, 2)), np.inf
        for _ in range(40):
            positions, state = optimiser.ask(state, rng)
            state = optimiser.tell(state, sphere(positions))
            position, value = optimiser.best(state)
            assert value == min(before, sphere(positions).min())
            assert value == pytest.approx(sphere(position[None])[0])
            before = value


def test_repulsion_by_hand() -> None:
    # Q_i Q_j / d^2 along the line: 6 / 4 between the first two; the third is too far, the fourth coincides.
    positions = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 9.0], [0.0, 0.0]])
    force = repulsion(positions, np.array([2.0, 3.0, 5.0, 0.0]), max_distance=9.0)
    assert force == pytest.approx(np.array([[-1.5, 0.0], [1.5, 0.0], [0.0, 0.0], [0.0, 0.0]]))


def test_charges_keep_the_swarm_apart() -> None:
    parameters = converging()
    spreads = [
        np.linalg.norm(fly(optimiser, swarm(10, 2), sphere, 150).positions.std(axis=0))
        for optimiser in (Pso(parameters), Cpso((1.0,) * 10, 5.0, parameters))
    ]
    assert spreads[0] < 1e-3
    assert spreads[1] > 0.3


def error_on_moving_peaks(optimiser: Optimiser[Particles], seed: int) -> float:
    """Return the mean error of the swarm's best value while the peak jumps every 30 steps (offline error)."""
    rng, peaks = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    state, errors = optimiser.init(rng.uniform(-20.0, 20.0, (20, 2))), []
    for _ in range(12):
        peak = peaks.uniform(-20.0, 20.0, 2)
        state = forgetful(state)
        for _ in range(30):
            positions, state = optimiser.ask(state, rng)
            state = optimiser.tell(state, np.linalg.norm(positions - peak, axis=1))
            errors.append(optimiser.best(state)[1])
    return float(np.mean(errors))


def test_charges_follow_moving_peaks_better() -> None:
    parameters = converging()
    half_charged = Cpso((4.0,) * 10 + (0.0,) * 10, 10.0, parameters)
    wins = [error_on_moving_peaks(half_charged, s) < error_on_moving_peaks(Pso(parameters), s) for s in range(8)]
    assert sum(wins) >= 7


def test_forgetting_lets_worse_values_lead() -> None:
    state = fly(Pso(), swarm(4, 2), sphere, 3)
    positions, state = Pso().ask(forgetful(state), np.random.default_rng(0))
    state = Pso().tell(state, np.array([1e6, 1e7, 1e7, 1e7]))
    assert np.array_equal(state.best_position, positions[0])
    assert state.best_value == 1e6


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: PsoParameters(c_c=-1.0), "c_c"),
        (lambda: PsoParameters(c_s=float("nan")), "c_s"),
        (lambda: PsoParameters(exponent=0), "exponent"),
        (lambda: Cpso((1.0, -1.0), 3.0), "charges"),
        (lambda: Cpso((1.0, 1.0), 0.0), "max_distance"),
        (lambda: Apso(lower=1.0, upper=1.0, moves=9), "lower"),
        (lambda: Apso(lower=0.0, upper=1.0, moves=0), "moves"),
    ],
)
def test_bad_parameters_are_named(make: Callable[[], object], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        make()


def test_one_charge_per_particle() -> None:
    with pytest.raises(ValueError, match="charges"):
        Cpso((1.0, 1.0), 3.0).init(swarm(3, 2))
