"""The choice of views of the archive strategy: joint, with hysteresis, and of single views."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.swarm.archive.selection import Views, choose_single_views, choose_views, still_held

SEEDS = st.integers(0, 2**32 - 1)


def coarse_views(shown: NDArray[np.float32], footprint: NDArray[np.float32], conflicts: NDArray[np.bool_]) -> Views:
    """Return views whose quarters of cells are all alike."""
    return Views(shown, footprint, conflicts, np.zeros((0, shown.shape[1], 4), np.float32))


def random_views(rng: np.random.Generator, count: int, cells: int = 30) -> Views:
    footprint = rng.random((count, cells)) < 0.4
    shown = footprint & (rng.random((count, cells)) < 0.5)
    places = rng.uniform(0.0, 8.0, (count, 2))
    conflicts = np.linalg.norm(places[:, None] - places, axis=2) < 2.0
    return coarse_views(shown.astype(np.float32), footprint.astype(np.float32), conflicts)


def score_of(views: Views, chosen: Sequence[int], area_exponent: float) -> float:
    rows = list(chosen)
    seen = float(np.sum(1.0 - np.prod(1.0 - views.shown[rows], axis=0)))
    return seen ** (1.0 + area_exponent) / float(views.footprints[rows].max(axis=0).sum())


class TestSelection:
    @pytest.mark.parametrize("area_exponent", [0.0, 0.5])
    def test_it_comes_close_to_the_best_of_all_sets(self, area_exponent: float) -> None:
        shares = []
        for seed in range(12):
            views = random_views(np.random.default_rng(seed), 9)
            chosen = choose_views(views, 3, [], area_exponent, hysteresis=0.0)
            fits = [
                s for s in combinations(range(9), 3) if not views.conflicts[np.ix_(s, s)][~np.eye(3, dtype=bool)].any()
            ]
            best = max(score_of(views, s, area_exponent) for s in fits)
            shares.append(score_of(views, chosen.tolist(), area_exponent) / best)
        assert min(shares) > 0.85
        assert np.mean(shares) > 0.97

    @given(SEEDS, st.integers(1, 6))
    @settings(max_examples=25)
    def test_chosen_views_keep_apart(self, seed: int, count: int) -> None:
        views = random_views(np.random.default_rng(seed), 12)
        chosen = choose_views(views, count, [], 0.0, hysteresis=0.0)
        assert len(chosen) <= count
        assert not views.conflicts[np.ix_(chosen, chosen)][~np.eye(len(chosen), dtype=bool)].any()

    def test_two_views_that_complement_each_other_beat_the_two_largest(self) -> None:
        shown = np.array([[1, 1, 1, 0, 0, 0], [1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 0]], dtype=np.float32)
        views = coarse_views(shown, np.ones_like(shown), np.eye(3, dtype=np.bool_))
        assert set(choose_views(views, 2, [], 0.0, 0.0).tolist()) in ({0, 2}, {1, 2})

    def test_gaps_within_a_cell_fill_each_other(self) -> None:
        """Three views show half of every cell, two of them the same half."""
        fine = np.zeros((3, 5, 4), dtype=np.float32)
        fine[:2, :, :2], fine[2, :, 2:] = 1.0, 1.0
        views = Views(fine.mean(axis=2), np.ones((3, 5), np.float32), np.eye(3, dtype=np.bool_), fine)
        assert set(choose_views(views, 2, [0, 1], 0.0, 0.0).tolist()) in ({0, 2}, {1, 2})

    def test_single_views_are_the_largest_that_keep_apart(self) -> None:
        shown = np.array([[1, 1, 1, 0, 0, 0], [1, 1, 1, 1, 0, 0], [0, 0, 0, 1, 1, 0], [0, 0, 0, 0, 0, 1]], np.float32)
        conflicts = np.eye(4, dtype=np.bool_)
        conflicts[0, 1] = conflicts[1, 0] = True
        views = coarse_views(shown, np.ones_like(shown), conflicts)
        assert choose_single_views(views, 2, [], hysteresis=0.0).tolist() == [1, 2]
        assert choose_single_views(views, 1, [0], hysteresis=0.5).tolist() == [0]

    def test_hysteresis_keeps_what_is_held(self) -> None:
        shown = np.zeros((2, 100), dtype=np.float32)
        shown[0, :50], shown[1, :52] = 1.0, 1.0
        views = coarse_views(shown, np.ones_like(shown), np.eye(2, dtype=np.bool_))
        assert choose_views(views, 1, [0], 0.0, hysteresis=0.1).tolist() == [0]
        assert choose_views(views, 1, [0], 0.0, hysteresis=0.01).tolist() == [1]

    def test_a_set_that_no_single_exchange_improves_is_given_up_for_a_better_one(self) -> None:
        """Two silhouettes: one is known to half, the other could be seen as a whole, but only by both drones."""
        left, right = np.arange(20) < 10, np.arange(20) >= 10
        shown = np.zeros((4, 20), dtype=np.float32)
        shown[0, :3] = shown[1, 3:6] = shown[2, 10:15] = shown[3, 15:20] = 1.0
        views = coarse_views(shown, np.array([left, left, right, right], dtype=np.float32), np.eye(4, dtype=np.bool_))
        assert set(choose_views(views, 2, [0, 1], 0.0, hysteresis=0.0).tolist()) == {2, 3}

    def test_without_candidates_nothing_is_chosen(self) -> None:
        empty = coarse_views(np.zeros((0, 4), np.float32), np.zeros((0, 4), np.float32), np.zeros((0, 0), np.bool_))
        assert len(choose_views(empty, 3, [], 0.3, 0.01)) == 0
        assert still_held(np.zeros((2, 0)), empty.conflicts, 0.4) == []
