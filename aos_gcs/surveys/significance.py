"""Significance of marks on the ground, by how much the images of a survey mark the ground around them.

Leaves and sunlit branches stand out of single images as much as persons do, but lie elsewhere on the ground in each of
them. How often an image marks a place where nothing is, and how much what it marks there exceeds the base score, is
learnt from the survey itself, within :data:`NEIGHBOURHOOD_M` of every place: the share q of marks, and Hill's estimate
of the tail of their scores (Hill, *A simple general approach to inference about the tail of a distribution*, Annals of
Statistics 3(5), 1975). Of n images that see a place, the number of marks by chance is binomial, and the sum of the
levels by which they exceed the base is then negative binomial. The significance of a place is -log10 of the probability
of a sum as large as the one seen, or of as many marks, where these are clearer. Places that stand out are left out of
the statistics, which are then computed once more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError

DEFAULT_FALSE_ALARMS_PER_HA = 0.25
PLACES_PER_HA = 20_000.0
"""Places of a hectare that chance can mark independently: one per half a square metre, what a mark covers."""
NEIGHBOURHOOD_M = 20.0
"""Edge of the square around a place whose marks tell how often chance marks it: some crowns wide."""
DISPERSION = 2.0
"""Variance of the number of marks over that of independent images: neighbours see the same branch at the same place."""
MIN_VIEWS = 2
"""Images that must mark a place: one alone cannot tell the ground from the leaves above it."""
_BLOCK_M = 1.0
"""Edge of the blocks that statistics are summed in."""
_STRIKING = 5.0
"""Significance from which a place takes no part in the statistics."""
_GUARDS = (3, 0, 0)
"""Edge of the square of blocks that a place is judged without, in each pass: at first a place must not hide itself."""
_PRIOR_M2 = 20.0
"""Area seen once with the statistics of the whole map that is added to those of a neighbourhood."""
_SPECKS = 3.0
"""Marks by chance that are added to those of the whole map: of what is rarer nothing is known."""
_SPECK_M2 = 0.36
_SHARE_STEP, _RATIO_STEP = 1.05, 0.02
"""Steps to which statistics are rounded up, so that equal places are computed once."""


@dataclass(frozen=True, slots=True, eq=False)
class AnomalySums:
    """Marks of the images on a raster, arrays of shape (rows, columns)."""

    count: NDArray[np.uint16]
    """Images that mark a cell."""
    excess: NDArray[np.uint32]
    """Sum of the levels by which these exceed the lowest, see :func:`~aos_gcs.surveys.levels.levels`."""

    @classmethod
    def none(cls, shape: tuple[int, int]) -> AnomalySums:
        """Return the sums of no image."""
        return cls(np.zeros(shape, dtype=np.uint16), np.zeros(shape, dtype=np.uint32))

    def part(self, window: tuple[slice, slice] | tuple[NDArray[np.intp], NDArray[np.intp]]) -> AnomalySums:
        """Return the sums of some rows and columns, or of single cells."""
        return AnomalySums(self.count[window], self.excess[window])


def significance_limit(false_alarms_per_ha: float) -> float:
    """Return the significance that chance exceeds at so many places per hectare.

    Raises:
        ConfigurationError: if the rate is not between 0 and that of places.
    """
    if not 0.0 < false_alarms_per_ha < PLACES_PER_HA:
        raise ConfigurationError(
            f"--false-alarms-per-ha must lie between 0 and {PLACES_PER_HA:g}, got {false_alarms_per_ha:g}."
        )
    return math.log10(PLACES_PER_HA / false_alarms_per_ha)


def significance(sums: AnomalySums, coverage: NDArray[np.uint16], cell_m: float) -> NDArray[np.float32]:
    """Return the significance of every cell, shape (rows, columns); 0 where fewer than :data:`MIN_VIEWS` mark it.

    Args:
        sums: marks of the images.
        coverage: images that see each cell.
        cell_m: edge of a cell.
    """
    rows, columns = np.nonzero(sums.count >= MIN_VIEWS)
    result = np.zeros(sums.count.shape, dtype=np.float32)
    if not rows.size:
        return result
    edge = max(1, round(_BLOCK_M / cell_m))
    covered, marked, exceeding = (_block_sums(plane, edge) for plane in (coverage, sums.count, sums.excess))
    block_rows, block_columns = rows // edge, columns // edge
    seen, own = coverage[rows, columns], sums.part((rows, columns))
    usual = np.ones(covered.shape, dtype=np.float64)
    for guard in _GUARDS:
        share, ratio = _background((covered * usual, marked * usual, exceeding * usual), cell_m, edge, guard)
        found = _surprise(seen, own, share[block_rows, block_columns], ratio[block_rows, block_columns])
        striking = np.zeros(usual.shape, dtype=np.uint8)
        striking[block_rows[found > _STRIKING], block_columns[found > _STRIKING]] = 1
        usual = 1.0 - cv2.dilate(striking, np.ones((3, 3), dtype=np.uint8)).astype(np.float64)
    result[rows, columns] = found
    return result


def _background(
    totals: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], cell_m: float, edge: int, guard: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the share of marks around each block, and the ratio of marks from one level to the next.

    Args:
        totals: sums of the images that see the cells of each block, that mark them, and of their excess.
        cell_m: edge of a cell.
        edge: edge of a block in cells.
        guard: edge of the square of blocks around each that takes no part, odd; 0: none.
    """
    seen, marked, excess = totals
    specks = _SPECKS * _SPECK_M2 / cell_m**2
    all_seen, all_marked = float(seen.sum()) + specks, float(marked.sum()) + specks
    mean_share, mean_excess = all_marked / all_seen, (float(excess.sum()) + specks) / all_marked
    prior = _PRIOR_M2 / cell_m**2
    blocks = max(5, round(NEIGHBOURHOOD_M / (edge * cell_m))) | 1

    def around(sums: NDArray[np.float64]) -> NDArray[np.float64]:
        whole, own = (
            cv2.boxFilter(sums, -1, (size, size), normalize=False, borderType=cv2.BORDER_CONSTANT)
            for size in (blocks, max(guard, 1))
        )
        return np.maximum(whole - own if guard else whole, 0.0)

    marked_near = around(marked) + prior * mean_share
    share = marked_near / (around(seen) + prior)
    mean_near = (around(excess) + prior * mean_share * mean_excess) / marked_near
    return np.clip(share, 1e-9, 0.9), np.clip(mean_near / (1.0 + mean_near), 1e-3, 0.99)


def _surprise(
    seen: NDArray[np.uint16], own: AnomalySums, share: NDArray[np.float64], ratio: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return how surely cells are more than chance, by how strongly they are marked or by how often, shape (n,)."""
    often = -np.log10(
        np.clip(scipy.special.betainc(own.count.astype(np.float64), seen - own.count + 1.0, share), 1e-300, 1.0)
    )
    return np.maximum(_strength(seen, own.excess, share, ratio), np.asarray(often / DISPERSION, dtype=np.float32))


def _strength(
    seen: NDArray[np.uint16], excess: NDArray[np.uint32], share: NDArray[np.float64], ratio: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return -log10 of the probability that chance exceeds the base by as much, shape (n,)."""
    share_step = np.ceil(np.log(share) / math.log(_SHARE_STEP))
    ratio_step = np.ceil(ratio / _RATIO_STEP)
    cases, of_cell = np.unique(np.stack((seen, excess, share_step, ratio_step), axis=1), axis=0, return_inverse=True)
    n, levels = cases[:, 0], cases[:, 1]
    q, g = np.minimum(_SHARE_STEP ** cases[:, 2], 0.95), np.minimum(cases[:, 3] * _RATIO_STEP, 0.99)
    chance = np.zeros(len(cases))
    expected = n * q
    most = int(np.minimum(n, np.ceil(expected + 10.0 * np.sqrt(expected) + 10.0)).max())
    for k in range(1, most + 1):
        possible = np.maximum(n - k, 0.0)
        choices = (
            scipy.special.gammaln(n + 1.0) - scipy.special.gammaln(k + 1.0) - scipy.special.gammaln(possible + 1.0)
        )
        marks = np.where(n >= k, np.exp(choices + k * np.log(q) + possible * np.log1p(-q)), 0.0)
        # The sum of k geometric variables reaches a level with the regularised incomplete beta function.
        chance += marks * np.where(levels > 0.0, scipy.special.betainc(np.maximum(levels, 1.0), k, g), 1.0)
    return np.asarray(-np.log10(np.clip(chance, 1e-300, 1.0)), dtype=np.float32)[of_cell.reshape(-1)]


def _block_sums(plane: NDArray[np.generic], edge: int) -> NDArray[np.float64]:
    """Return the sums of square blocks of cells; those at the end may be smaller."""
    in_rows = np.add.reduceat(plane, np.arange(0, plane.shape[0], edge), axis=0, dtype=np.float64)
    return np.asarray(np.add.reduceat(in_rows, np.arange(0, plane.shape[1], edge), axis=1))
