"""The oracle against exact solutions of small cases, and its promises on random ones."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.lab.oracle import best_places, find_oracle
from aos_gcs.lab.worlds import Target, WorldParameters, build_world

BoolArray = NDArray[np.bool_]
SPACING_M = 2.0


def random_case(seed: int, layers: int = 3, side: int = 4, cells: int = 20) -> tuple[BoolArray, BoolArray, np.ndarray]:
    """Places on a grid of 1 m; neighbouring places see similar cells, of which the forest hides about half."""
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2).astype(float)
    centres = rng.uniform(0.0, side, (cells, 2))
    reach = rng.uniform(1.5, 2.5, (layers, 1, 1))
    footprint = np.linalg.norm(places[:, None] - centres, axis=-1) < reach
    return footprint & (rng.random(footprint.shape) < 0.5), footprint, places


def score(seen: BoolArray, footprint: BoolArray, chosen: np.ndarray) -> float:
    layers = np.arange(len(chosen))
    area = np.count_nonzero(seen[layers, chosen].any(axis=0))
    return float(area / max(1, np.count_nonzero(footprint[layers, chosen].any(axis=0))))


def exact(seen: BoolArray, footprint: BoolArray, places: np.ndarray) -> float:
    """The optimum, by a mixed-integer program and Dinkelbach's iteration over its linear form."""
    weight = 0.0
    while True:
        chosen = exact_for_weight(seen, footprint, places, weight)
        value = score(seen, footprint, chosen)
        if value <= weight + 1e-9:
            return value
        weight = value


def exact_for_weight(seen: BoolArray, footprint: BoolArray, places: np.ndarray, weight: float) -> np.ndarray:
    """Maximise (cells seen) - weight (cells of the footprint). Variables: choices (n, c), cells seen, footprint."""
    n, c, cells = seen.shape
    choices = n * c
    rows, lower, upper = [], [], []

    def require(row: np.ndarray, low: float, high: float) -> None:
        rows.append(row)
        lower.append(low)
        upper.append(high)

    def variables() -> np.ndarray:
        return np.zeros(choices + 2 * cells)

    for layer in range(n):
        row = variables()
        row[layer * c : (layer + 1) * c] = 1.0
        require(row, 1.0, 1.0)
    for cell in range(cells):
        row = variables()
        row[:choices] = seen[:, :, cell].ravel()
        row[choices + cell] = -1.0
        require(row, 0.0, np.inf)  # a cell is seen only if a chosen place sees it
        for index in np.flatnonzero(footprint[:, :, cell].ravel()):
            row = variables()
            row[index], row[choices + cells + cell] = -1.0, 1.0
            require(row, 0.0, np.inf)  # a cell of a chosen place's footprint belongs to the union
    near = np.argwhere(np.linalg.norm(places[:, None] - places, axis=-1) < SPACING_M)
    for first, second in near[near[:, 0] <= near[:, 1]]:
        row = variables()
        for layer in range(n):
            row[layer * c + first] = row[layer * c + second] = 1.0
        require(row, 0.0, 1.0)
    cost = np.concatenate([np.zeros(choices), -np.ones(cells), np.full(cells, weight)])
    solution = milp(
        cost,
        constraints=LinearConstraint(np.array(rows), lower, upper),
        integrality=np.ones_like(cost),
        bounds=Bounds(0.0, 1.0),
    )
    assert solution.success
    return solution.x[:choices].reshape(n, c).argmax(axis=1)


def test_comes_close_to_the_exact_solution_of_small_cases() -> None:
    reached, optimal = [], []
    for seed in range(3):
        seen, footprint, places = random_case(seed, cells=12)
        chosen = best_places(seen, footprint, places, SPACING_M)
        reached.append(score(seen, footprint, chosen))
        optimal.append(exact(seen, footprint, places))
    assert np.less_equal(reached, np.array(optimal) + 1e-9).all()
    assert np.sum(reached) >= 0.95 * np.sum(optimal)


@given(seed=st.integers(0, 10_000))
def test_keeps_the_spacing_and_cannot_be_improved_by_one_exchange(seed: int) -> None:
    seen, footprint, places = random_case(seed)
    chosen = best_places(seen, footprint, places, SPACING_M)
    distances = np.linalg.norm(places[chosen][:, None] - places[chosen], axis=-1)
    assert distances[~np.eye(len(chosen), dtype=bool)].min() >= SPACING_M
    value = score(seen, footprint, chosen)
    for layer in range(len(chosen)):
        others = np.delete(chosen, layer)
        free = np.linalg.norm(places[:, None] - places[others], axis=-1).min(axis=1) >= SPACING_M
        for place in np.flatnonzero(free):
            changed = chosen.copy()
            changed[layer] = place
            assert score(seen, footprint, changed) <= value + 1e-12


def test_says_when_there_is_no_room() -> None:
    seen, footprint, places = random_case(0)
    with pytest.raises(ValueError, match="no room for 3 vehicles"):
        best_places(seen, footprint, places, 100.0)


def test_refuses_shapes_that_do_not_fit() -> None:
    seen, footprint, places = random_case(0)
    with pytest.raises(ValueError, match="one shape"):
        best_places(seen, footprint[:, :5], places, SPACING_M)


def test_beats_random_choices_in_the_simulated_forest() -> None:
    pytest.importorskip("aos_sim.lab_world", reason="needs the simulator")
    world = build_world(WorldParameters(seed=3, side_m=40.0))
    target = Target(tuple(world.area_enu_m.mean(axis=0)))
    camera = CameraModel.from_fov(256, 256, math.radians(50.0))
    heights_m = [35.0, 36.0, 37.0, 38.0]
    oracle = find_oracle(world, camera, target, heights_m, 4.2, radius_m=12.0)
    rng = np.random.default_rng(0)
    for _ in range(20):
        positions = target.position_enu_m + rng.uniform(-8.0, 8.0, (4, 2))
        poses = [nadir_pose([*place, height]) for place, height in zip(positions, heights_m, strict=True)]
        views = world.view_target(poses, camera, target)
        visibility = views.seen.any(axis=0).sum() / views.unoccluded.any(axis=0).sum()
        assert visibility < oracle.visibility
    assert 0.0 < oracle.visibility <= 1.0
    assert oracle.positions_enu_m.shape == (4, 2)
