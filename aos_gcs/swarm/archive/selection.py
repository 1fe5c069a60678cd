"""The joint choice of views: which of those in the archive the swarm should hold at the same time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive.raster import FloatArray, IntArray

MAX_SWEEPS = 3
"""Limit of the exchanges over all views; a choice that starts from the last one settles after one or two."""


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """Candidates, c of them, on the cells about the target that any of them may show."""

    shown: NDArray[np.float32]
    """Probability that a cell is seen, shape (c, cells)."""
    footprints: NDArray[np.float32]
    """1 where it would be seen without forest, else 0, shape (c, cells)."""
    conflicts: NDArray[np.bool_]
    """Pairs that are too near to each other to be held together, each with itself, shape (c, c)."""

    def __len__(self) -> int:
        return len(self.shown)


@dataclass(frozen=True, slots=True, eq=False)
class Outlook:
    """Parts of the target that a set of views leaves unseen."""

    hidden: NDArray[np.float32]
    """Probability that no view shows a cell, shape (cells,)."""
    uncovered: NDArray[np.float32]
    """1 where no footprint lies, else 0, shape (cells,)."""

    @classmethod
    def of(cls, views: Views, chosen: Sequence[int]) -> Outlook:
        """Return the outlook of the chosen views; none at all leaves everything hidden."""
        rows = list(chosen)
        return cls(
            np.prod(1.0 - views.shown[rows], axis=0, dtype=np.float32),
            1.0 - views.footprints[rows].max(axis=0, initial=np.float32(0.0)),
        )

    def score(self, area_exponent: float) -> float:
        """Return how good the set is."""
        return float(score(np.sum(1.0 - self.hidden), np.sum(1.0 - self.uncovered), area_exponent))

    def scores_with(
        self, shown: NDArray[np.floating], footprints: NDArray[np.floating], area_exponent: float
    ) -> FloatArray:
        """Return how good the set is with each of c further views, shape (c,)."""
        seen = np.sum(1.0 - self.hidden) + shown @ self.hidden
        covered = np.sum(1.0 - self.uncovered) + footprints @ self.uncovered
        return score(seen, covered, area_exponent)


def score(seen: FloatArray | np.floating, covered: FloatArray | np.floating, area_exponent: float) -> FloatArray:
    """Return the normalised visibility times a power of the area: seen / covered * seen ** area_exponent."""
    return np.asarray(seen, dtype=np.float64) ** (1.0 + area_exponent) / np.maximum(covered, 1e-9)


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
    if not held:
        return continued
    anew = _completed(views, count, [], area_exponent, hysteresis)
    old_score, new_score = (Outlook.of(views, chosen.tolist()).score(area_exponent) for chosen in (continued, anew))
    return anew if new_score > old_score * (1.0 + 2.0 * hysteresis) else continued


def _completed(views: Views, count: int, held: Sequence[int], area_exponent: float, hysteresis: float) -> IntArray:
    """Return the views held, brought to their number greedily and improved by exchanges."""
    chosen = list(held)
    while len(chosen) > count:
        rests = [chosen[:i] + chosen[i + 1 :] for i in range(len(chosen))]
        chosen = max(rests, key=lambda rest: Outlook.of(views, rest).score(area_exponent))
    while len(chosen) < count and len(views):
        scores = _scores(views, chosen, area_exponent)
        best = int(scores.argmax())
        if scores[best] < 0.0:
            break
        chosen.append(best)
    for _ in range(MAX_SWEEPS):
        before = tuple(chosen)
        for place, present in enumerate(before):
            scores = _scores(views, chosen[:place] + chosen[place + 1 :], area_exponent)
            best = int(scores.argmax())
            if scores[best] > scores[present] * (1.0 + hysteresis):
                chosen[place] = best
        if before == tuple(chosen):
            break
    return np.array(chosen, dtype=np.int64)


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


def _scores(views: Views, chosen: Sequence[int], area_exponent: float) -> FloatArray:
    """Return the score of the chosen views with each candidate, shape (c,); -1 where it stands too near."""
    scores = Outlook.of(views, chosen).scores_with(views.shown, views.footprints, area_exponent)
    scores[views.conflicts[:, list(chosen)].any(axis=1)] = -1.0
    return scores
