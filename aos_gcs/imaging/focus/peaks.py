"""Peaks of a curve, with what tells a main one from a ripple."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Peak:
    """A local maximum of equally spaced values."""

    index: int
    """Where it is; the middle of a plateau, rounded down."""
    prominence: float
    """How far the curve has to fall on either side, at least, before it rises above the peak, or ends."""
    width: float
    """Distance, in indices, between where the curve has fallen by half of the prominence on either side."""


def peaks_of(values: NDArray[np.float64]) -> list[Peak]:
    """Return the local maxima of a curve, shape (n,), in their order; its ends are none."""
    starts = np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)
    ends = np.append(starts[1:], len(values)) - 1
    levels = values[starts]
    tops = 1 + np.flatnonzero((levels[1:-1] > levels[:-2]) & (levels[1:-1] > levels[2:]))
    return [_peak(values, int(starts[top] + ends[top]) // 2) for top in tops]


def _peak(values: NDArray[np.float64], index: int) -> Peak:
    sides = (values[index::-1], values[index:])
    prominence = min(_drop(side) for side in sides)
    return Peak(index, prominence, sum(_steps_to(values[index] - prominence / 2.0, side) for side in sides))


def _drop(side: NDArray[np.float64]) -> float:
    """Return how far a curve falls below its first value before it rises above it."""
    higher = np.flatnonzero(side > side[0])
    return float(side[0] - side[: higher[0] if higher.size else None].min())


def _steps_to(level: float, side: NDArray[np.float64]) -> float:
    """Return after how many steps a curve has fallen to a level, linear in between."""
    after = int(np.flatnonzero(side <= level)[0])
    before = after - 1
    return before + float((side[before] - level) / (side[before] - side[after]))
