"""What every registered strategy promises, whoever wrote it, and what those promise that follow a leader."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from aos_gcs.store.codec import decode, encode
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.model import Observation, Strategy, TargetMasks
from aos_gcs.swarm.registry import available_strategies, make_strategy
from aos_gcs.swarm.state import dump_rng
from tests.fakes.generators import load_rng

FloatArray = NDArray[np.float64]
Case = tuple[str, Mapping[str, object]]
NORTH = np.array([0.0, 1.0])
TARGET = np.array([3.0, 25.0])

SWITCHES: tuple[Case, ...] = (
    ("aos-pso", {"personal_best_memory": True}),
    ("aos-pso", {"revisit_radius_m": 1.0, "projection_line": True}),
    ("aos-pso", {"repulsion_cutoff_m": 6.3, "follow_target_speed": False}),
    ("aos-apso-paper", {"min_factor": 0.25, "max_factor": 0.8, "repulsion_cutoff_m": 6.3}),
    ("aos-apso", {"timed_steps": False}),
    ("aos-apso", {"keeps_looks": False, "joint_choice": False, "wander_m": 1.0}),
    ("aos-apso-paper", {"personal_best_memory": True, "revisit_radius_m": 0.5, "leader_stabilised": False}),
    ("blind-parallel", {"projection_line": True}),
    ("blind-sequential", {"width_m": 0.0}),
)
"""Parameters that make a strategy take other ways."""

CASES: tuple[Case, ...] = (*((name, {}) for name in available_strategies()), *SWITCHES)
FOLLOWERS = tuple(case for case in CASES if isinstance(make_strategy(*case), LeaderFollowing))


def label(case: Case) -> str:
    name, parameters = case
    return ",".join([name, *parameters])


@pytest.fixture(params=CASES, ids=label)
def strategy(request: pytest.FixtureRequest) -> Strategy[Any]:
    return make_strategy(*request.param)


@pytest.fixture(params=FOLLOWERS, ids=label)
def follower(request: pytest.FixtureRequest) -> Strategy[Any]:
    return make_strategy(*request.param)


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


def with_masks(observation: Observation) -> Observation:
    """Add what the imaging knows beyond the fitness: heights, and a random half of the target per vehicle."""
    n = len(observation.vehicle_ids)
    marked = np.random.default_rng(n).uniform(size=(n, 8, 8)) < 0.5
    masks = TargetMasks(marked, west_m=TARGET[0] - 0.4, north_m=TARGET[1] + 0.4, resolution_m=0.1)
    return replace(
        observation, heights_m=np.arange(35.0, 35.0 + n), masks=masks if observation.target_in_view else None
    )


def line_of(n: int, north_m: float = 0.0) -> FloatArray:
    return np.column_stack([4.2 * (np.arange(n) - (n - 1) / 2), np.full(n, north_m)])


def fly(strategy: Strategy[Any], seed: int, steps: int, n: int = 6) -> FloatArray:
    rng, state, positions = np.random.default_rng(seed), strategy.init(NORTH), line_of(n, north_m=8.0)
    trajectory = [positions]
    for _ in range(steps):
        state = strategy.tell(state, with_masks(observe(positions)))
        positions, state = strategy.ask(state, rng)
        trajectory.append(positions)
    return np.array(trajectory)


class TestEveryStrategy:
    def test_has_its_name_and_a_spacing(self, strategy: Strategy[Any]) -> None:
        assert strategy.name in available_strategies()
        assert strategy.spacing_m > 0.0

    def test_same_seed_same_trajectory(self, strategy: Strategy[Any]) -> None:
        assert np.array_equal(fly(strategy, seed=5, steps=12), fly(strategy, seed=5, steps=12))

    def test_state_and_generator_survive_json_in_mid_run(self, strategy: Strategy[Any]) -> None:
        rng, state, positions = np.random.default_rng(9), strategy.init(NORTH), line_of(6, north_m=8.0)
        for step in range(12):
            state = strategy.tell(state, with_masks(observe(positions)))
            saved_state, saved_rng = json.dumps(encode(state)), json.dumps(dump_rng(rng))
            loaded, loaded_rng = decode(type(state), json.loads(saved_state)), load_rng(json.loads(saved_rng))
            positions, state = strategy.ask(state, rng)
            again, state_again = strategy.ask(loaded, loaded_rng)
            assert np.array_equal(positions, again), f"step {step}"
            assert json.dumps(encode(state)) == json.dumps(encode(state_again))
            assert rng.bit_generator.state == loaded_rng.bit_generator.state
            assert strategy.diagnostics(state) == strategy.diagnostics(state_again)

    @pytest.mark.parametrize("n", [2, 3, 10])
    def test_positions_are_finite_and_factors_fit_at_each_step(self, strategy: Strategy[Any], n: int) -> None:
        rng, state, positions = np.random.default_rng(2), strategy.init(NORTH), line_of(n, north_m=8.0)
        for _ in range(20):
            state = strategy.tell(state, with_masks(observe(positions)))
            positions, state = strategy.ask(state, rng)
            diagnostics = strategy.diagnostics(state)
            assert positions.shape == (n, 2)
            assert np.isfinite(positions).all()
            if diagnostics.c_s_m is not None and diagnostics.c_c_m is not None:
                assert diagnostics.c_c_m > 0.0
                assert diagnostics.c_s_m + diagnostics.c_c_m <= strategy.spacing_m * (1.0 + 1e-12)
                # APSO's own factors know no such order: that is what is untuned about them.
                assert diagnostics.c_s_m > diagnostics.c_c_m or strategy.name == "aos-apso-untuned"
            if diagnostics.evolutionary_factor is not None:
                assert 0.0 <= diagnostics.evolutionary_factor <= 1.0

    def test_vehicles_leave_and_join(self, strategy: Strategy[Any]) -> None:
        rng, state, positions = np.random.default_rng(1), strategy.init(NORTH), line_of(10, north_m=20.0)
        for ids in ([1, 2, 3, 4, 5], [1, 3, 5], [3, 5], [3, 5, 7, 9], [11, 12]):
            rows = [vehicle_id % 10 for vehicle_id in ids]
            told = with_masks(observe(positions[rows], ids=ids, in_view=True))
            moved, state = strategy.ask(strategy.tell(state, told), rng)
            assert moved.shape == (len(ids), 2)
            assert np.isfinite(moved).all()
            assert strategy.diagnostics(state).leader_id in {None, *ids}

    def test_missing_frames(self, strategy: Strategy[Any]) -> None:
        for delivered in (0, 1, 3):
            rng, state, positions = np.random.default_rng(3), strategy.init(NORTH), line_of(4, north_m=20.0)
            for step in range(6):
                seen = observe(positions, in_view=True)
                fitness = np.where((np.arange(4) + step) % 4 < delivered, seen.fitness, np.nan)
                positions, state = strategy.ask(strategy.tell(state, replace(seen, fitness=fitness)), rng)
                leader_id = strategy.diagnostics(state).leader_id
                assert np.isfinite(positions).all(), f"{delivered} frames"
                assert leader_id is None or np.isfinite(fitness[leader_id - 1]), f"{delivered} frames"

    def test_target_lost_and_found_again(self, strategy: Strategy[Any]) -> None:
        rng, state, positions = np.random.default_rng(4), strategy.init(NORTH), line_of(6, north_m=18.0)
        for in_view in (False, True, True, False, False, True, False, True):
            state = strategy.tell(state, with_masks(observe(positions, in_view=in_view)))
            positions, state = strategy.ask(state, rng)
            assert np.isfinite(positions).all()
            assert strategy.diagnostics(state).leader_id is None or in_view

    def test_coincident_drones_cause_no_error(self, strategy: Strategy[Any]) -> None:
        for in_view in (False, True):
            told = strategy.tell(strategy.init(NORTH), observe(np.zeros((6, 2)), in_view=in_view))
            assert np.isfinite(strategy.ask(told, np.random.default_rng(0))[0]).all(), f"{in_view=}"

    def test_order_of_the_report_changes_nothing(self, strategy: Strategy[Any]) -> None:
        positions = line_of(6) + np.random.default_rng(3).normal(size=(6, 2))
        order = [3, 0, 5, 1, 4, 2]
        ids = np.arange(1, 7)
        for in_view in (False, True):
            results = []
            for rows in (list(range(6)), order):
                seen = observe(positions[rows], ids=ids[rows].tolist(), in_view=in_view)
                results.append(strategy.ask(strategy.tell(strategy.init(NORTH), seen), np.random.default_rng(8))[0])
            assert np.array_equal(results[0][order], results[1]), f"{in_view=}"

    def test_arguments_are_left_alone(self, strategy: Strategy[Any]) -> None:
        observation = with_masks(observe(line_of(5, north_m=20.0)))
        before = json.dumps(encode(observation))
        strategy.ask(strategy.tell(strategy.init(NORTH), observation), np.random.default_rng(0))
        assert json.dumps(encode(observation)) == before

    def test_ask_needs_tell(self, strategy: Strategy[Any]) -> None:
        rng, state = np.random.default_rng(0), strategy.init(NORTH)
        with pytest.raises(RuntimeError, match="tell"):
            strategy.ask(state, rng)
        _, state = strategy.ask(strategy.tell(state, observe(line_of(3))), rng)
        with pytest.raises(RuntimeError, match="tell"):
            strategy.ask(state, rng)

    def test_observations_that_do_not_fit_are_refused(self, strategy: Strategy[Any]) -> None:
        observation = observe(line_of(3), in_view=True)
        changes: tuple[tuple[dict[str, Any], str], ...] = (
            ({"vehicle_ids": (), "positions_enu_m": np.zeros((0, 2)), "fitness": np.zeros(0)}, "or more vehicles"),
            ({"vehicle_ids": (1, 1, 2)}, "differ"),
            ({"positions_enu_m": np.zeros((3, 3))}, "shape"),
            ({"fitness": np.zeros(2)}, "shape"),
            ({"positions_enu_m": np.full((3, 2), np.nan)}, "finite"),
            ({"target_enu_m": np.array([np.nan, 0.0])}, "target"),
        )
        for change, text in changes:
            with pytest.raises(ValueError, match=text):
                strategy.tell(strategy.init(NORTH), replace(observation, **change))

    def test_a_scanning_direction_without_length_is_refused(self, strategy: Strategy[Any]) -> None:
        with pytest.raises(ValueError, match="direction"):
            strategy.init(np.zeros(2))


class TestLeaderFollowing:
    def test_another_seed_makes_another_trajectory(self, follower: Strategy[Any]) -> None:
        assert not np.array_equal(fly(follower, seed=5, steps=12), fly(follower, seed=6, steps=12))

    @pytest.mark.parametrize("n", [2, 3, 10])
    def test_drones_keep_half_of_the_spacing(self, follower: Strategy[Any], n: int) -> None:
        """Scattering promises no more: not c4, and in flight between two waypoints nothing at all."""
        assert isinstance(follower, LeaderFollowing)
        # A detour around a sampled spot is made after scattering, and may come nearer to a neighbour.
        share = 0.5 if follower.parameters.revisit_radius_m is None else 0.25
        rng, state, positions = np.random.default_rng(n), follower.init(NORTH), line_of(n, north_m=16.0)
        for _ in range(20):
            state = follower.tell(state, observe(positions, in_view=True))
            positions, state = follower.ask(state, rng)
            assert pdist(positions).min() >= share * follower.spacing_m

    def test_branches_follow_the_view_and_a_loss_resets_the_factors(self, follower: Strategy[Any]) -> None:
        rng, state, positions = np.random.default_rng(4), follower.init(NORTH), line_of(6, north_m=18.0)
        start = follower.diagnostics(state)
        for in_view in (False, True, True, False, True):
            state = follower.tell(state, observe(positions, in_view=in_view))
            positions, state = follower.ask(state, rng)
            diagnostics = follower.diagnostics(state)
            assert diagnostics.branch == ("pso" if in_view else "line")
            assert (diagnostics.evolutionary_factor is not None) == in_view
            if not in_view:
                assert (diagnostics.c_s_m, diagnostics.c_c_m) == (start.c_s_m, start.c_c_m)

    def test_the_best_view_leads_and_a_vehicle_without_a_frame_never_does(self, follower: Strategy[Any]) -> None:
        near = observe(line_of(5, north_m=20.0))
        best = int(near.fitness.argmax())
        fitness = near.fitness.copy()
        fitness[best] = np.nan
        blind = replace(near, fitness=fitness, leader_id=near.vehicle_ids[best])
        state = follower.tell(follower.init(NORTH), blind)
        positions, state = follower.ask(state, np.random.default_rng(0))
        expected = near.vehicle_ids[int(np.nanargmax(fitness))]
        assert follower.diagnostics(state).leader_id == expected
        assert np.isfinite(positions).all()

    def test_without_any_frame_the_line_goes_on(self, follower: Strategy[Any]) -> None:
        dark = replace(observe(line_of(4), in_view=True), fitness=np.full(4, np.nan))
        positions, state = follower.ask(follower.tell(follower.init(NORTH), dark), np.random.default_rng(0))
        assert follower.diagnostics(state).branch == "line"
        assert follower.diagnostics(state).leader_id is None
        assert np.isfinite(positions).all()

    def test_the_choice_of_the_imaging_leads_unless_it_is_missing(self, follower: Strategy[Any]) -> None:
        near = observe(line_of(5, north_m=20.0))
        for chosen, expected in ((2, 2), (99, near.vehicle_ids[int(near.fitness.argmax())])):
            state = follower.tell(follower.init(NORTH), replace(near, leader_id=chosen))
            _, state = follower.ask(state, np.random.default_rng(0))
            assert follower.diagnostics(state).leader_id == expected

    def test_when_the_leader_drops_out_the_next_best_leads(self, follower: Strategy[Any]) -> None:
        rng, state, positions = np.random.default_rng(6), follower.init(NORTH), line_of(6, north_m=20.0)
        ids = [1, 2, 3, 4, 5, 6]
        while len(ids) > 2:
            state = follower.tell(state, observe(positions, ids=ids, in_view=True))
            positions, state = follower.ask(state, rng)
            leader_id = follower.diagnostics(state).leader_id
            assert leader_id in ids
            lost = ids.index(leader_id)
            ids, positions = ids[:lost] + ids[lost + 1 :], np.delete(positions, lost, axis=0)

    def test_coincident_drones_part(self, follower: Strategy[Any]) -> None:
        for in_view in (False, True):
            told = follower.tell(follower.init(NORTH), observe(np.zeros((6, 2)), in_view=in_view))
            positions, _ = follower.ask(told, np.random.default_rng(0))
            assert pdist(positions).min() > 0.5, f"{in_view=}"

    def test_one_vehicle_is_no_swarm(self, follower: Strategy[Any]) -> None:
        with pytest.raises(ValueError, match="2 or more vehicles"):
            follower.tell(follower.init(NORTH), observe(line_of(1)))
