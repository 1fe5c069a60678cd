"""AOS-PSO and AOS-APSO: one step by hand, branches, scanning direction and speed, adaptation, behaviour in a field."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.swarm.aos_apso import make_aos_apso_paper, make_aos_apso_untuned
from aos_gcs.swarm.aos_pso import make_aos_pso, make_aos_pso_stabilised
from aos_gcs.swarm.blind import make_parallel
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.model import Diagnostics, Observation
from aos_gcs.swarm.scatter import scatter
from aos_gcs.swarm.state import SwarmState

FloatArray = NDArray[np.float64]
NORTH = np.array([0.0, 1.0])


def observation(
    positions: FloatArray, target: FloatArray | None, fitness: FloatArray | None = None, *, first_id: int = 1
) -> Observation:
    n = len(positions)
    return Observation(
        vehicle_ids=tuple(range(first_id, first_id + n)),
        positions_enu_m=positions,
        fitness=np.arange(n, dtype=np.float64) if fitness is None else fitness,
        target_in_view=target is not None,
        target_enu_m=target,
    )


def test_default_branch_by_hand() -> None:
    strategy = make_aos_pso({})
    positions = np.array([[-1.0, 0.0], [1.0, 0.0]])
    state = strategy.tell(strategy.init(NORTH), observation(positions, None))
    moved, _ = strategy.ask(state, np.random.default_rng(0))
    # North: w points west, so the first drone's place is at +2.1 m; v = c3 SD + c5 (l - x) = (0.3 * 3.1, 2).
    assert moved == pytest.approx(np.array([[-1.0 + 0.93, 2.0], [1.0 - 0.93, 2.0]]))


def test_pso_branch_by_hand() -> None:
    strategy = make_aos_pso({})
    positions = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 20.0]])
    state = strategy.tell(strategy.init(NORTH), observation(positions, np.array([5.0, 5.0]), np.array([0.0, 9.0, 1.0])))
    moved, state = strategy.ask(state, np.random.default_rng(4))
    angles = np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, 3)
    to_leader = np.array([[1.0, 0.0], [0.0, 0.0], [10.0 / np.sqrt(500.0), -20.0 / np.sqrt(500.0)]])
    expected = positions + np.column_stack([np.cos(angles), np.sin(angles)]) + 2.0 * to_leader
    assert moved == pytest.approx(scatter(expected, 4.2, np.random.default_rng(0)))
    assert strategy.diagnostics(state).branch == "pso"
    assert strategy.diagnostics(state).leader_id == 2


def test_leader_stabilisation_leaves_the_leader_to_its_random_step() -> None:
    positions = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])
    seen = observation(positions, np.array([5.0, 5.0]))
    ways = {}
    for stabilised in (False, True):
        strategy = make_aos_pso({"leader_stabilised": stabilised})
        moved, _ = strategy.ask(strategy.tell(strategy.init(NORTH), seen), np.random.default_rng(4))
        ways[stabilised] = float(np.linalg.norm(moved[2] - positions[2]))
    assert ways[True] == pytest.approx(1.0)
    assert ways[False] != pytest.approx(1.0, abs=0.05)


def test_line_order_is_a_switch() -> None:
    positions = np.array([[-5.0, 0.0], [5.0, 0.0]])
    for by_projection, inwards in ((False, True), (True, False)):
        strategy = make_aos_pso({"projection_line": by_projection, "c5": 1.0})
        moved, _ = strategy.ask(
            strategy.tell(strategy.init(NORTH), observation(positions, None)), np.random.default_rng(0)
        )
        assert (moved[0, 0] > 0.0) == inwards


def lose_target(strategy_parameters: dict[str, object], sightings: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Show the target some steps long, then lose it; return the centre's next way and its last place."""
    strategy = make_aos_pso(strategy_parameters)
    state: SwarmState = strategy.init(NORTH)
    positions = np.array([[-2.1, 0.0], [2.1, 0.0]])
    for target in sightings:
        state = strategy.tell(state, observation(positions, target))
        _, state = strategy.ask(state, np.random.default_rng(0))
    state = strategy.tell(state, observation(positions, None))
    moved, _ = strategy.ask(state, np.random.default_rng(0))
    return moved.mean(axis=0), positions.mean(axis=0)


def test_after_a_loss_the_line_scans_towards_where_the_target_was_last_seen() -> None:
    moved, before = lose_target({}, [np.array([0.0, 9.0]), np.array([30.0, 0.0])])
    assert (moved - before) / np.linalg.norm(moved - before) == pytest.approx([1.0, 0.0])


@pytest.mark.parametrize(
    ("step_m", "expected_m"), [(0.0, 2.0), (3.0, 3.0), (9.0, 4.2)], ids=["still", "walking", "faster than samples"]
)
def test_scanning_follows_the_speed_of_a_tracked_target(step_m: float, expected_m: float) -> None:
    sightings = [np.array([0.0, 20.0 + step_m * step]) for step in range(4)]
    moved, before = lose_target({}, sightings)
    assert np.linalg.norm(moved - before) == pytest.approx(expected_m)
    moved, before = lose_target({"follow_target_speed": False}, sightings)
    assert np.linalg.norm(moved - before) == pytest.approx(2.0)


def test_a_track_ends_with_the_view_and_a_new_one_starts() -> None:
    strategy = make_aos_pso({})
    state = strategy.init(NORTH)
    positions = np.array([[-2.1, 0.0], [2.1, 0.0]])
    for target in (np.array([0.0, 10.0]), np.array([0.0, 14.0]), None, np.array([50.0, 0.0])):
        state = strategy.tell(state, observation(positions, target))
    assert state.track is not None
    assert (state.track.sightings, state.track.in_view, state.track.step_m) == (1, True, 0.0)


def test_over_the_target_the_old_direction_stays() -> None:
    strategy = make_aos_pso({})
    positions = np.array([[-2.0, 7.0], [2.0, 7.0]])
    state = strategy.tell(strategy.init(NORTH), observation(positions, np.array([0.0, 7.0])))
    assert state.scan_direction_enu == (0.0, 1.0)


def decide(strategy: LeaderFollowing, state: SwarmState, seen: Observation) -> tuple[Diagnostics, SwarmState]:
    _, state = strategy.ask(strategy.tell(state, seen), np.random.default_rng(0))
    return strategy.diagnostics(state), state


RING = np.array([[0.0, 0.0], [4.0, 0.0], [-4.0, 0.0], [0.0, 4.0], [0.0, -4.0]])
CENTRAL = observation(RING, np.array([1.0, 1.0]), np.array([5.0, 1.0, 1.0, 1.0, 1.0]))
REMOTE = replace(CENTRAL, fitness=np.array([1.0, 9.0, 1.0, 1.0, 1.0]))


def test_adaptation_runs_in_the_pso_branch_and_is_reset_by_the_default_one() -> None:
    strategy = make_aos_apso_paper({})
    diagnostics, state = decide(strategy, strategy.init(NORTH), CENTRAL)
    assert (diagnostics.evolutionary_factor, diagnostics.evolutionary_state) == (0.0, "convergence")
    # Both slightly up: 1 - 0.95 * 0.5 = 0.525.
    assert diagnostics.c_s_m == pytest.approx(4.2 * 0.525)
    assert diagnostics.c_c_m == pytest.approx(4.2 * 0.525**2)
    diagnostics, state = decide(strategy, state, REMOTE)
    assert diagnostics.evolutionary_state == "jumping_out"
    diagnostics, state = decide(strategy, state, observation(RING, None))
    assert (diagnostics.branch, diagnostics.evolutionary_factor, diagnostics.evolutionary_state) == ("line", None, None)
    assert (diagnostics.c_s_m, diagnostics.c_c_m) == pytest.approx((2.1, 1.05))


def test_untuned_adaptation_is_that_of_apso() -> None:
    strategy = make_aos_apso_untuned({})
    state = strategy.init(NORTH)
    assert (strategy.diagnostics(state).c_s_m, strategy.diagnostics(state).c_c_m) == (2.0, 2.0)
    for _ in range(9):
        diagnostics, state = decide(strategy, state, REMOTE)
    assert diagnostics.evolutionary_state == "jumping_out"
    assert (diagnostics.c_s_m, diagnostics.c_c_m) == pytest.approx((2.5, 1.5))
    # Central now: both slightly up and, as their sum is 4 already, scaled back.
    diagnostics, state = decide(strategy, state, CENTRAL)
    assert diagnostics.evolutionary_state == "convergence"
    assert diagnostics.c_s_m is not None
    assert diagnostics.c_c_m is not None
    assert diagnostics.c_s_m + diagnostics.c_c_m == pytest.approx(4.0)
    assert diagnostics.c_c_m > 1.5
    diagnostics, _ = decide(strategy, state, observation(RING, None))
    assert (diagnostics.c_s_m, diagnostics.c_c_m) == (2.0, 2.0)


def test_untuned_factors_fit_a_small_spacing() -> None:
    strategy = make_aos_apso_untuned({"c4_m": 3.2})
    diagnostics = strategy.diagnostics(strategy.init(NORTH))
    assert (diagnostics.c_s_m, diagnostics.c_c_m) == (1.6, 1.6)


def test_the_stabilised_form_differs_in_two_switches_only() -> None:
    published, stabilised = make_aos_pso({}), make_aos_pso_stabilised({})
    assert asdict(stabilised.parameters) == {
        **asdict(published.parameters),
        "leader_stabilised": True,
        "projection_line": True,
    }


def test_a_state_of_another_strategy_is_refused() -> None:
    with pytest.raises(ValueError, match="aos-apso"):
        make_aos_apso_paper({}).diagnostics(make_parallel({}).init(NORTH))


def visibility(positions: FloatArray, peak: FloatArray, occlusion_seed: int) -> FloatArray:
    """A toy forest: the view falls with the distance to the peak, and each 1 m cell hides a random part of it."""
    distances = np.linalg.norm(positions - peak, axis=1)
    cells = np.floor(positions).astype(int)
    gaps = [np.random.default_rng([occlusion_seed, *(cell % 100_003)]).uniform(0.2, 1.0) for cell in cells]
    return np.exp(-((distances / 15.0) ** 2)) * np.array(gaps)


@pytest.mark.parametrize("seed", range(5))
def test_aos_apso_gathers_around_the_peak(seed: int) -> None:
    strategy, rng = make_aos_apso_paper({}), np.random.default_rng(seed)
    peak = np.array([8.0, 45.0])
    positions = np.column_stack([4.2 * (np.arange(10) - 4.5), np.zeros(10)])
    state = strategy.init(NORTH)
    for _ in range(70):
        fitness = visibility(positions, peak, seed)
        seen = bool(fitness.max() > 0.15)
        state = strategy.tell(state, observation(positions, peak if seen else None, fitness))
        positions, state = strategy.ask(state, rng)
    assert np.linalg.norm(positions.mean(axis=0) - peak) < 8.0
    assert np.median(np.linalg.norm(positions - peak, axis=1)) < 15.0
