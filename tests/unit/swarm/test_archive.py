"""AOS-APSO with views kept on a toy forest: one layer of leaves with holes, a body that is a vertical line."""

import json
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from aos_gcs.errors import ConfigurationError
from aos_gcs.store.codec import decode, encode
from aos_gcs.swarm.archive.plan import choose_lines
from aos_gcs.swarm.archive.raster import CELL_M, CELLS, FINE_CELL_M, SIDE, anchor_of
from aos_gcs.swarm.archive.strategy import (
    FORGET_STEPS,
    REPLAN_WAY_M,
    REST_STEPS,
    SEARCH_STEPS,
    ViewKeeping,
    ViewState,
    make_aos_archive,
)
from aos_gcs.swarm.model import Observation, TargetMasks
from aos_gcs.swarm.registry import make_strategy
from tests.fakes.silhouettes import footprints

FloatArray = NDArray[np.float64]
NORTH = np.array([0.0, 1.0])
BODY_HEIGHT_M, BODY_RADIUS_M = 1.75, 0.2
LEAVES_HEIGHT_M = 14.0


@dataclass(frozen=True)
class ToyForest:
    """Leaves in one plane; which squares of 0.8 m are open is drawn from the seed."""

    open_squares: NDArray[np.bool_]

    @classmethod
    def grow(cls, seed: int, open_share: float = 0.25) -> "ToyForest":
        return cls(np.random.default_rng(seed).random((128, 128)) < open_share)

    def sees(self, camera_enu_m: FloatArray, height_m: float, points_enu_m: FloatArray) -> NDArray[np.bool_]:
        """Whether rays from points on the ground pass a hole on the way to the camera."""
        crossing_m = points_enu_m + (camera_enu_m - points_enu_m) * LEAVES_HEIGHT_M / height_m
        column, row = (np.floor(crossing_m / 0.8).astype(int) % len(self.open_squares)).T
        return np.asarray(self.open_squares[row, column])


@dataclass(frozen=True)
class Look:
    observation: Observation
    visibility: float
    area_m2: float


def layers(n: int) -> FloatArray:
    return np.arange(35.0, 35.0 + n)


def line_of(n: int, north_m: float) -> FloatArray:
    return np.column_stack([4.2 * (np.arange(n) - (n - 1) / 2), np.full(n, north_m)])


def look(forest: ToyForest, target_enu_m: FloatArray, positions_enu_m: FloatArray, heights_m: FloatArray) -> Look:
    """What the drones see of a target, on the raster about it; in view when anything is seen."""
    anchor = anchor_of(target_enu_m)
    corner_m = anchor * FINE_CELL_M + np.array([-0.5, 0.5]) * SIDE * CELL_M
    axis_m = CELL_M * (np.arange(SIDE) + 0.5)
    east_m, north_m = np.meshgrid(corner_m[0] + axis_m, corner_m[1] - axis_m)
    cells_m = np.column_stack([east_m.ravel(), north_m.ravel()])
    marked, footprint = np.zeros((len(positions_enu_m), CELLS), bool), np.zeros((len(positions_enu_m), CELLS), bool)
    for i, (position_m, height_m) in enumerate(zip(positions_enu_m, heights_m, strict=True)):
        slope = (position_m - target_enu_m) / height_m
        if np.linalg.norm(slope) < 0.45:
            footprint[i] = footprints(slope[None], height_m, BODY_HEIGHT_M, BODY_RADIUS_M)[0]
            marked[i] = footprint[i] & forest.sees(position_m, height_m, cells_m)
    seen = marked.any(axis=0)
    masks = TargetMasks(marked.reshape(-1, SIDE, SIDE), corner_m[0], corner_m[1], CELL_M) if seen.any() else None
    observation = Observation(
        vehicle_ids=tuple(range(1, len(positions_enu_m) + 1)),
        positions_enu_m=positions_enu_m,
        fitness=marked.sum(axis=1) * CELL_M**2,
        target_in_view=bool(seen.any()),
        target_enu_m=cells_m[seen].mean(axis=0) if seen.any() else None,
        heights_m=heights_m,
        masks=masks,
    )
    return Look(observation, seen.sum() / max(footprint.any(axis=0).sum(), 1), seen.sum() * CELL_M**2)


@dataclass(frozen=True)
class Flight:
    visibility: FloatArray
    min_distance_m: FloatArray
    steps_m: FloatArray
    target_error_m: FloatArray
    branches: list[str]
    state: ViewState


@cache
def fly(
    *,
    seed: int = 1,
    steps: int = 40,
    n: int = 6,
    speed_m: float = 0.0,
    keeps_looks: bool = True,
    joint_choice: bool = True,
    wander_m: float = 0.0,
) -> Flight:
    """Fly to a target at the origin that walks east by so many metres per step; equal flights are flown once."""
    strategy = make_aos_archive({"keeps_looks": keeps_looks, "joint_choice": joint_choice, "wander_m": wander_m})
    forest, rng, state = ToyForest.grow(seed), np.random.default_rng(seed), strategy.init(NORTH)
    positions = line_of(n, north_m=-8.0)
    visibility, distances, ways, errors, branches = [], [], [], [], []
    for step in range(steps):
        target = np.array([speed_m * step, 0.0])
        seen = look(forest, target, positions, layers(n))
        state = strategy.tell(state, seen.observation)
        following, state = strategy.ask(state, rng)
        visibility.append(seen.visibility)
        branches.append(strategy.diagnostics(state).branch)
        distances.append(pdist(following).min())
        ways.append(np.linalg.norm(following - positions, axis=1).max())
        errors.append(np.nan if state.target is None else np.linalg.norm(state.target.position_enu_m - target))
        positions = following
    return Flight(np.array(visibility), np.array(distances), np.array(ways), np.array(errors), branches, state)


class TestFlight:
    def test_both_are_found_by_their_names(self) -> None:
        for name in ("aos-apso", "aos-archive"):
            strategy = make_strategy(name, {})
            assert isinstance(strategy, ViewKeeping)
            assert strategy.name == name

    def test_more_is_visible_than_from_around_the_best_view(self) -> None:
        """AOS-PSO gathers around one drone; the same eyes show more where they complement each other."""
        archived, followed = [], []
        for seed in range(3):
            archived.append(fly(seed=seed).visibility[20:].mean())
            forest, rng = ToyForest.grow(seed), np.random.default_rng(seed)
            strategy = make_strategy("aos-pso", {})
            positions = line_of(6, north_m=-8.0)
            state, visibility = strategy.init(NORTH), []
            for _ in range(40):
                seen = look(forest, np.zeros(2), positions, layers(6))
                visibility.append(seen.visibility)
                positions, state = strategy.ask(strategy.tell(state, seen.observation), rng)
            followed.append(np.mean(visibility[20:]))
        assert np.mean(archived) > np.mean(followed) + 0.1

    def test_without_memory_only_the_views_of_the_last_step_are_known(self) -> None:
        assert len(fly().state.looks) > 20
        assert len(fly(keeps_looks=False).state.looks) <= 6

    def test_drones_that_have_settled_rest_unless_they_are_to_wander(self) -> None:
        assert np.median(fly(steps=80).steps_m[-8:]) == 0.0
        assert np.median(fly(steps=80, wander_m=0.5).steps_m[-8:]) >= 0.5 - 1e-9

    def test_single_views_are_another_choice_than_joint_ones(self) -> None:
        alone, together = (
            np.mean([fly(seed=seed, joint_choice=joint).visibility[20:].mean() for seed in range(3)])
            for joint in (False, True)
        )
        assert together > alone

    def test_waypoints_keep_their_distance_and_steps_are_short(self) -> None:
        flight = fly(n=10)
        archive = np.array(flight.branches) == "archive"
        assert archive[-20:].all()
        settled = np.flatnonzero(archive)[3:]
        assert flight.min_distance_m[settled].min() >= 2.6 - 1e-9
        assert np.median(flight.steps_m[settled]) <= 1.0 + 1e-9

    def test_a_still_target_is_located_within_a_cell_or_two(self) -> None:
        flight = fly()
        assert flight.state.target is not None
        assert not flight.state.target.is_moving
        assert np.nanmedian(flight.target_error_m[-10:]) < 2 * CELL_M

    @pytest.mark.parametrize("speed_m", [0.5, 1.5])
    def test_a_walking_target_is_followed(self, speed_m: float) -> None:
        flight = fly(n=8, speed_m=speed_m)
        assert flight.state.target is not None
        assert flight.state.target.is_moving
        assert np.median(flight.target_error_m[-10:]) < 1.0
        assert flight.visibility[-20:].mean() > 0.2

    def test_lines_are_chosen_anew_after_some_metres_and_rarely_at_rest(self, monkeypatch: pytest.MonkeyPatch) -> None:
        chosen_at: list[int] = []
        asked: list[int] = []

        def counted(*arguments: Any) -> FloatArray:
            chosen_at.append(len(asked))
            return choose_lines(*arguments)

        monkeypatch.setattr("aos_gcs.swarm.archive.strategy.choose_lines", counted)
        strategy, forest, rng = make_aos_archive({}), ToyForest.grow(1), np.random.default_rng(1)
        state, positions = strategy.init(NORTH), line_of(6, north_m=-8.0)
        for step in range(60):
            asked.append(step)
            seen = look(forest, np.zeros(2), positions, layers(6))
            positions, state = strategy.ask(strategy.tell(state, seen.observation), rng)
        gaps = np.diff(chosen_at)
        assert gaps.min() == REPLAN_WAY_M / strategy.parameters.max_step_m
        assert gaps.max() == REST_STEPS

    @pytest.mark.parametrize(
        ("step_s", "longest_m"),
        [(None, 1.0), (0.1, 1.0), (1.0, 3.0), (30.0, 8.0)],
        ids=["untold", "short", "mid", "long"],
    )
    def test_steps_fit_the_time_that_they_take(self, step_s: float | None, longest_m: float) -> None:
        """The way of a step to far views: what 3 m/s make of the time of the last one, from 1 m to 8 m."""
        forest, positions = ToyForest.grow(1, open_share=0.0), line_of(6, north_m=-14.0)
        seen = look(ToyForest.grow(1, open_share=1.0), np.zeros(2), positions, layers(6)).observation
        nothing = look(forest, np.zeros(2), positions, layers(6)).observation
        ways = {}
        for name in ("aos-apso", "aos-archive"):
            strategy = make_strategy(name, {"min_distance_m": 0.1})
            state = strategy.init(NORTH)
            for step, observation in enumerate((seen, nothing, nothing)):
                time_s = None if step_s is None else step * step_s
                state = strategy.tell(state, replace(observation, time_s=time_s))
                following, state = strategy.ask(state, np.random.default_rng(0))
            ways[name] = np.linalg.norm(following - positions, axis=1).max()
        assert ways["aos-apso"] == pytest.approx(longest_m)
        assert ways["aos-archive"] == pytest.approx(1.0)


class TestState:
    def test_it_survives_json_in_mid_run(self) -> None:
        strategy, state = make_aos_archive({}), fly(steps=15).state
        loaded = decode(ViewState, json.loads(json.dumps(encode(state), allow_nan=False)))
        positions = line_of(6, north_m=-2.0)
        seen = look(ToyForest.grow(1), np.zeros(2), positions, layers(6)).observation
        results = [strategy.ask(strategy.tell(start, seen), np.random.default_rng(2)) for start in (state, loaded)]
        assert np.array_equal(results[0][0], results[1][0])
        assert json.dumps(encode(results[0][1])) == json.dumps(encode(results[1][1]))

    def test_it_stays_small(self) -> None:
        assert len(json.dumps(encode(fly(n=10).state))) < 100_000

    def test_a_target_out_of_view_is_forgotten_only_after_some_steps(self) -> None:
        strategy, state = make_aos_archive({}), fly(steps=20).state
        positions = line_of(6, north_m=0.0)
        nothing = look(ToyForest.grow(1, open_share=0.0), np.zeros(2), positions, layers(6)).observation
        for _ in range(SEARCH_STEPS):
            _, state = strategy.ask(strategy.tell(state, nothing), np.random.default_rng(0))
            assert strategy.diagnostics(state).branch == "archive"
        _, state = strategy.ask(strategy.tell(state, nothing), np.random.default_rng(0))
        assert strategy.diagnostics(state).branch == "line"
        assert len(state.looks) == 0

    def test_a_swarm_that_sees_nothing_any_more_looks_elsewhere(self) -> None:
        """What stood still must be there: the views held are in the archive, others are not."""
        strategy, state = make_aos_archive({}), fly(steps=20).state
        positions, rng = line_of(6, north_m=0.0), np.random.default_rng(0)
        blind = ToyForest.grow(1, open_share=0.0)
        looks, visited = len(state.looks), [positions]
        for _ in range(SEARCH_STEPS - 1):
            nothing = look(blind, np.zeros(2), positions, layers(6)).observation
            positions, state = strategy.ask(strategy.tell(state, nothing), rng)
            visited.append(positions)
        assert len(state.looks) > looks
        assert np.ptp(np.array(visited), axis=0).max() > 3.0

    def test_another_target_is_taken_up_only_when_the_first_stays_away(self) -> None:
        strategy, state = make_aos_archive({}), fly(steps=20).state
        looks = len(state.looks)
        other = np.array([12.0, 0.0])
        seen = look(ToyForest.grow(1, open_share=1.0), other, line_of(6, north_m=0.0), layers(6)).observation
        for _ in range(FORGET_STEPS):
            state = strategy.tell(state, seen)
            assert len(state.looks) == looks
        for _ in range(2):
            state = strategy.tell(state, seen)
        assert state.target is not None
        assert np.linalg.norm(state.target.position_enu_m - other) < 0.5

    def test_without_masks_or_heights_it_steps_as_the_papers_aos_apso(self) -> None:
        positions = line_of(6, north_m=-2.0)
        seen = look(ToyForest.grow(1), np.zeros(2), positions, layers(6)).observation
        reference = make_strategy("aos-apso-paper", {})
        told = reference.tell(reference.init(NORTH), seen)
        expected, _ = reference.ask(told, np.random.default_rng(5))
        for poorer in (replace(seen, masks=None), replace(seen, heights_m=None)):
            strategy = make_aos_archive({})
            moved, state = strategy.ask(strategy.tell(strategy.init(NORTH), poorer), np.random.default_rng(5))
            assert np.array_equal(moved, expected)
            assert strategy.diagnostics(state).branch == "pso"

    def test_masks_of_something_else_than_the_target_are_left_alone(self) -> None:
        seen = look(ToyForest.grow(1, open_share=1.0), np.zeros(2), line_of(6, north_m=-2.0), layers(6)).observation
        strategy = make_aos_archive({})
        state = strategy.tell(strategy.init(NORTH), replace(seen, target_enu_m=np.array([12.0, 0.0])))
        _, state = strategy.ask(state, np.random.default_rng(0))
        assert state.target is None
        assert strategy.diagnostics(state).branch == "pso"

    def test_a_vehicle_without_a_frame_is_not_archived(self) -> None:
        positions = line_of(6, north_m=-2.0)
        seen = look(ToyForest.grow(1), np.zeros(2), positions, layers(6)).observation
        strategy = make_aos_archive({})
        missing = replace(seen, fitness=np.where(np.arange(6) < 2, np.nan, seen.fitness))
        assert len(strategy.tell(strategy.init(NORTH), seen).looks) == 6
        assert len(strategy.tell(strategy.init(NORTH), missing).looks) == 4


class TestBadInput:
    @pytest.mark.parametrize(
        ("parameters", "text"),
        [
            ({"aperture_radius_m": 0.0}, "aperture_radius_m must be above 0"),
            ({"max_step_m": -1.0}, "max_step_m must be above 0"),
            ({"optimism": 1.5}, "optimism must be at least 0 and at most 1"),
            ({"min_distance_m": 4.0}, "min_distance_m must be at most view_spacing_m"),
            ({"hysteresis": -0.1}, "hysteresis must be at least 0"),
            ({"body_height_m": 20.0}, "body_height_m must be below canopy_height_m"),
            ({"gamma": 1.5}, "gamma must be above 0 and below 1"),
            ({"max_step_m": 9.0}, "max_step_m must be at most long_step_m"),
            ({"apperture": 3.0}, "has no parameter apperture"),
        ],
    )
    def test_parameters_are_refused_by_name(self, parameters: dict[str, object], text: str) -> None:
        with pytest.raises(ConfigurationError, match=text):
            make_aos_archive(parameters)

    @pytest.mark.parametrize("heights", [np.full(5, 35.0), np.zeros(6), np.full(6, np.nan)])
    def test_heights_that_do_not_fit_are_refused(self, heights: FloatArray) -> None:
        positions = line_of(6, north_m=0.0)
        seen = look(ToyForest.grow(1), np.zeros(2), positions, np.full(6, 35.0)).observation
        strategy = make_aos_archive({})
        with pytest.raises(ValueError, match="heights"):
            strategy.tell(strategy.init(NORTH), replace(seen, heights_m=heights))

    def test_masks_of_other_vehicles_are_refused(self) -> None:
        positions = line_of(6, north_m=0.0)
        seen = look(ToyForest.grow(1), np.zeros(2), positions, np.full(6, 35.0)).observation
        assert seen.masks is not None
        strategy = make_aos_archive({})
        with pytest.raises(ValueError, match="masks"):
            strategy.tell(strategy.init(NORTH), replace(seen, masks=replace(seen.masks, marked=seen.masks.marked[:5])))
