"""Peaks of a sampled curve: where they are, how far they stand out and how wide they are.

Defined as in ``scipy.signal``, which takes a second to import in every process, since it loads SciPy's statistics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CurvePeak:
    """A sample, or the middle of several equal ones, above both of its neighbours."""

    index: int
    prominence: float
    """Height above the higher one of the lowest values on either side, each looked for up to the next higher value."""
    width: float
    """Width at half the prominence, in samples, interpolated between them."""


def curve_peaks(values: Sequence[float]) -> list[CurvePeak]:
    """Return all peaks in their order along the curve; its first and last values are none."""
    peaks = []
    start = 1
    while start < len(values) - 1:
        end = start
        while end < len(values) - 1 and values[end + 1] == values[start]:
            end += 1
        if end < len(values) - 1 and values[start - 1] < values[start] > values[end + 1]:
            peaks.append(_measured(values, (start + end) // 2))
        start = end + 1
    return peaks


def _measured(values: Sequence[float], index: int) -> CurvePeak:
    left, right = _base(values, index, -1), _base(values, index, 1)
    prominence = values[index] - max(values[left], values[right])
    level = values[index] - prominence / 2
    return CurvePeak(index, prominence, _crossing(values, index, right, level) - _crossing(values, index, left, level))


def _base(values: Sequence[float], index: int, step: int) -> int:
    """Return the index of the lowest value on one side of a peak, before the first one that is higher than the peak."""
    base = at = index
    while 0 <= at < len(values) and values[at] <= values[index]:
        if values[at] < values[base]:
            base = at
        at += step
    return base


def _crossing(values: Sequence[float], index: int, base: int, level: float) -> float:
    """Return where the curve falls to a level on its way from a peak to the base on one side, in samples."""
    step = 1 if base > index else -1
    at = index
    while at != base and values[at] > level:
        at += step
    if values[at] >= level:
        return float(at)
    return at - step * (level - values[at]) / (values[at - step] - values[at])
