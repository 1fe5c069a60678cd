"""The joint choice of views: which of those in the archive the swarm should hold at the same time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive.raster import FloatArray, IntArray

MAX_SWEEPS = 3
"""Limit of the exchanges per view; a choice that starts from the last one settles after one or two."""


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """Candidates, c of them, on the cells about the target that any of them may show."""

    shown: NDArray[np.float32]
    """Probability that a cell is seen, shape (c, cells)."""
    footprints: NDArray[np.float32]
    """1 where it would be seen without forest, else 0, shape (c, cells)."""
    conflicts: NDArray[np.bool_]
    """Pairs that are too near to each other to be held together, each with itself, shape (c, c)."""
    fine: NDArray[np.float32]
    """Probability that each quarter of a cell is seen, of the first candidates, shape (f, cells, 4).

    What is known of gaps between leaves is finer than what can be hoped for: the other candidates show the quarters of
    a cell alike. Two views may fill each other's gaps within a cell.
    """

    def __len__(self) -> int:
        return len(self.shown)


def score(seen: NDArray[np.float32], covered: NDArray[np.float32], area_exponent: float) -> NDArray[np.float32]:
    """Return the normalised visibility times a power of the area: seen / covered * seen ** area_exponent."""
    return np.asarray(seen ** np.float32(1.0 + area_exponent) / np.maximum(covered, np.float32(1e-9)))


def choose_views(views: Views, count: int, held: Sequence[int], area_exponent: float, hysteresis: float) -> IntArray:
    """Return the indices of views that are best together, fewer than ``count`` where they would stand too near.

    Maximum coverage with conflicts is NP-hard; greedy choice and exchanges come close to the optimum. They start from
    the views held, and once more from none, for a set that no single exchange improves may still be a poor one. The new
    set must be better by twice the hysteresis, as all drones may have to fly for it.

    Args:
        views: the candidates.
        count: number of views to choose.
        held: those of the step before, without conflicts; drones that hold their views need not fly.
        area_exponent: see :func:`score`.
        hysteresis: share by which an exchange must improve the score.
    """
    continued = _completed(views, count, held, area_exponent, hysteresis)
    if held:
        anew = _completed(views, count, [], area_exponent, hysteresis)
        if anew.score() > continued.score() * (1.0 + 2.0 * hysteresis):
            continued = anew
    return np.array(continued.chosen, dtype=np.int64)


def choose_single_views(views: Views, count: int, held: Sequence[int], hysteresis: float) -> IntArray:
    """Return the indices of the views that show most, each for itself; for the arguments see :func:`choose_views`."""
    seen = views.shown.sum(axis=1)
    seen[list(held)] *= 1.0 + hysteresis
    chosen: list[int] = []
    for index in np.argsort(-seen, kind="stable").tolist():
        if len(chosen) < count and not views.conflicts[index, chosen].any():
            chosen.append(index)
    return np.array(chosen, dtype=np.int64)


def _completed(views: Views, count: int, held: Sequence[int], area_exponent: float, hysteresis: float) -> _Choice:
    """Return the views held, brought to their number greedily and improved by exchanges."""
    choice = _Choice(views, held, area_exponent)
    while len(choice.chosen) > count:
        choice.drop_weakest()
    while len(choice.chosen) < count and len(views) and choice.add_best():
        pass
    for _ in range(MAX_SWEEPS * len(choice.chosen)):
        if not choice.exchange(hysteresis):
            break
    return choice


def _products(factors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the products of k rows without each in turn, and of all in the last row, shape (k + 1, ...)."""
    products = np.ones((len(factors) + 1, *factors.shape[1:]), dtype=np.float32)
    for row, factor in enumerate(factors):
        products[:row] *= factor
        products[row + 1 :] *= factor
    return products


def still_held(distances_m: FloatArray, conflicts: NDArray[np.bool_], same_m: float) -> list[int]:
    """Return which candidates are the views chosen before, as far as they still go together.

    Args:
        distances_m: distance of each view chosen before to each candidate, shape (chosen, c).
        conflicts: see :class:`Views`.
        same_m: distance from which a candidate is another view.
    """
    held: list[int] = []
    for row in distances_m:
        nearest = int(row.argmin()) if len(row) else -1
        if nearest >= 0 and row[nearest] < same_m and not conflicts[nearest, held].any():
            held.append(nearest)
    return held


class _Choice:
    """Views chosen so far, and what they leave unseen; its methods change it."""

    def __init__(self, views: Views, chosen: Sequence[int], area_exponent: float) -> None:
        self._views, self._exponent = views, area_exponent
        self.chosen = list(chosen)

    def score(self) -> float:
        """Return how good the set is."""
        hidden, uncovered = self._rests()
        return float(score(np.sum(1.0 - hidden[-1].mean(axis=1)), np.sum(1.0 - uncovered[-1]), self._exponent))

    def drop_weakest(self) -> None:
        """Leave out the view without which the others are best."""
        hidden, uncovered = (left[:-1] for left in self._rests())
        scores = score((1.0 - hidden.mean(axis=2)).sum(axis=1), (1.0 - uncovered).sum(axis=1), self._exponent)
        del self.chosen[int(scores.argmax())]

    def add_best(self) -> bool:
        """Add the view that improves the set most, and return whether there was one."""
        hidden, uncovered = self._rests()
        scores = self._scores_beside(hidden[-1:], uncovered[-1:])[:, 0]
        scores[self._views.conflicts[self.chosen].any(axis=0)] = -1.0
        best = int(scores.argmax())
        if scores[best] < 0.0:
            return False
        self.chosen.append(best)
        return True

    def exchange(self, hysteresis: float) -> bool:
        """Make the exchange of one view that improves the set most, and return whether there was one."""
        hidden, uncovered = self._rests()
        scores = self._scores_beside(hidden[:-1], uncovered[:-1])
        pairs = self._views.conflicts[:, self.chosen]
        scores[pairs.sum(axis=1, keepdims=True) - pairs > 0] = -1.0
        places = np.arange(len(self.chosen))
        best = scores.argmax(axis=0)
        gains = scores[best, places] - scores[self.chosen, places] * (1.0 + hysteresis)
        place = int(gains.argmax())
        if gains[place] <= 0.0:
            return False
        self.chosen[place] = int(best[place])
        return True

    def _rests(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return what is left without each of the k views in turn, and in the last row with all.

        The first array is the probability that no view shows a quarter of a cell, shape (k + 1, cells, 4), the second
        one 1 where no footprint lies and else 0, shape (k + 1, cells).
        """
        views = self._views
        shown = [
            views.fine[index] if index < len(views.fine) else np.repeat(views.shown[index][:, None], 4, axis=1)
            for index in self.chosen
        ]
        seen = np.array(shown, dtype=np.float32).reshape(len(shown), views.shown.shape[1], 4)
        return _products(1.0 - seen), _products(1.0 - views.footprints[self.chosen])

    def _scores_beside(self, hidden: NDArray[np.float32], uncovered: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the score of each candidate beside sets that leave so much, k of them, shape (c, k)."""
        views, share = self._views, np.float32(0.25)
        rows, quarters, coarse = len(views.fine), hidden[0].size, hidden.mean(axis=2)
        seen = np.empty((len(views), len(hidden)), dtype=np.float32)
        seen[:rows] = share * (views.fine.reshape(rows, quarters) @ hidden.reshape(-1, quarters).T)
        seen[rows:] = views.shown[rows:] @ coarse.T
        seen += (1.0 - coarse).sum(axis=1)
        covered = views.footprints @ uncovered.T + (1.0 - uncovered).sum(axis=1)
        return score(seen, covered, self._exponent)
