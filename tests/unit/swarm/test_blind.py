"""Blind sampling: the grid of one drone, the line of many, and that neither reacts."""

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.swarm.blind import grid_place, make_parallel, make_sequential
from aos_gcs.swarm.model import Observation

FloatArray = NDArray[np.float64]
NORTH = np.array([0.0, 1.0])


def seen(positions: FloatArray, *, target: FloatArray | None = None) -> Observation:
    n = len(positions)
    return Observation(tuple(range(1, n + 1)), positions, np.arange(float(n)), target is not None, target)


def test_rows_are_flown_to_and_fro() -> None:
    places = [grid_place(index, width_m=8.0, spacing_m=4.0) for index in range(7)]
    assert places == [(-4.0, 0.0), (0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (-4.0, 4.0), (-4.0, 8.0)]


def test_without_a_width_the_grid_is_a_line() -> None:
    assert [grid_place(index, 0.0, 4.0) for index in range(3)] == [(0.0, 0.0), (0.0, 4.0), (0.0, 8.0)]


def test_one_drone_flies_the_grid_and_the_others_stay() -> None:
    strategy = make_sequential({"c4_m": 4.0, "width_m": 8.0})
    positions, state = np.array([[10.0, 5.0], [50.0, 5.0]]), strategy.init(NORTH)
    flown = []
    for _ in range(4):
        positions, state = strategy.ask(strategy.tell(state, seen(positions)), np.random.default_rng(0))
        flown.append(positions[0])
        assert np.array_equal(positions[1], [50.0, 5.0])
    # Northwards the line's axis points west.
    assert np.array(flown) == pytest.approx(np.array([[14.0, 5.0], [10.0, 5.0], [6.0, 5.0], [6.0, 9.0]]))


def test_one_drone_is_enough_for_the_grid() -> None:
    strategy = make_sequential({})
    state = strategy.tell(strategy.init(NORTH), seen(np.zeros((1, 2))))
    assert strategy.ask(state, np.random.default_rng(0))[0].shape == (1, 2)


def test_when_the_flying_drone_drops_out_another_goes_on() -> None:
    strategy = make_sequential({"width_m": 0.0})
    state = strategy.tell(strategy.init(NORTH), seen(np.array([[0.0, 0.0], [30.0, 0.0]])))
    _, state = strategy.ask(state, np.random.default_rng(0))
    alone = Observation((2,), np.array([[30.0, 0.0]]), np.zeros(1), False)
    positions, _ = strategy.ask(strategy.tell(state, alone), np.random.default_rng(0))
    assert positions == pytest.approx(np.array([[0.0, 4.2]]))


def test_the_line_scans_on_over_the_target() -> None:
    strategy = make_parallel({})
    positions, state = np.column_stack([4.2 * np.arange(5)[::-1], np.zeros(5)]), strategy.init(NORTH)
    start = positions.copy()
    for _ in range(10):
        told = strategy.tell(state, seen(positions, target=np.array([90.0, 6.0])))
        positions, state = strategy.ask(told, np.random.default_rng(0))
    assert positions == pytest.approx(start + np.array([0.0, 20.0]))
    assert strategy.diagnostics(state).leader_id is None
