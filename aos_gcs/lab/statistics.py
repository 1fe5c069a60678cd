"""Statistics of campaigns: means with confidence intervals, and paired comparisons with correction for their number.

Runs of different strategies from the same initialisation share forest, target and start: they are compared pairwise,
which removes the large differences between forests from the result.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CONFIDENCE = 0.95
_CALIBRATION_BINS = 10
"""Ranges of probability, equally wide, within which it is compared with the share of what it is said of."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean with its confidence interval."""

    mean: float
    low: float
    high: float
    count: int

    @property
    def half_width(self) -> float:
        """Half of the interval's width."""
        return (self.high - self.low) / 2


@dataclass(frozen=True, slots=True)
class PairedDifference:
    """Paired comparison of a variant with the reference, over initialisations that both have run."""

    variant: str
    difference: Interval
    """Mean of variant minus reference."""
    share_better: float
    """Share of the initialisations in which the variant is ahead; ties count half."""
    p_value: float
    """Two-sided Wilcoxon signed-rank test."""
    p_corrected: float
    """p value after Holm's correction for all variants compared with the reference."""


@dataclass(frozen=True, slots=True)
class Share:
    """A proportion with Wilson's interval."""

    hits: int
    trials: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The proportion; NaN without trials."""
        return self.hits / self.trials if self.trials else math.nan

    @property
    def text(self) -> str:
        """Hits of trials, the proportion and its interval in percent, for tables."""
        if not self.trials:
            return "-"
        low, high = 100 * self.low, 100 * self.high
        return f"{self.hits} of {self.trials}: {100 * self.value:.0f} % ({low:.0f} to {high:.0f})"

    @classmethod
    def of(cls, hits: int, trials: int) -> Share:
        """Return the proportion with its interval; without trials the interval is that of ignorance."""
        if not trials:
            return cls(0, 0, 0.0, 1.0)
        # A second to import, which only what computes intervals should pay, here and below.
        from scipy import stats  # noqa: PLC0415

        interval = stats.binomtest(hits, trials).proportion_ci(CONFIDENCE, method="wilson")
        return cls(hits, trials, float(interval.low), float(interval.high))


@dataclass(frozen=True, slots=True)
class PerHectare:
    """Events per searched hectare with their exact Poisson interval."""

    events: int
    hectares: float
    value: float
    low: float
    high: float

    @classmethod
    def of(cls, events: int, hectares: float) -> PerHectare:
        """Return the rate; without an area nothing is known of it."""
        if hectares == 0.0:
            return cls(events, 0.0, math.nan, 0.0, math.inf)
        from scipy import stats  # noqa: PLC0415

        tail = (1.0 - CONFIDENCE) / 2.0
        low = float(stats.chi2.ppf(tail, 2 * events)) / 2.0 if events else 0.0
        high = float(stats.chi2.ppf(1.0 - tail, 2 * events + 2)) / 2.0
        return cls(events, hectares, events / hectares, low / hectares, high / hectares)

    def text(self, digits: int) -> str:
        """Return events, hectares, and the rate with its interval to so many decimals, for tables."""
        if not self.hectares:
            return "-"
        rate = f"{self.value:.{digits}f} ({self.low:.{digits}f} to {self.high:.{digits}f})"
        return f"{self.events} in {self.hectares:.2f} ha: {rate}"


def mean_interval(values: FloatArray) -> Interval:
    """Return the mean over runs with Student's interval; a single run has an interval without bounds.

    Args:
        values: one number per run, shape (runs,); NaN ones are left out.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Interval(math.nan, math.nan, math.nan, 0)
    mean = float(finite.mean())
    half = float(finite.std(ddof=1)) * _width_per_deviation(len(finite)) if len(finite) > 1 else math.inf
    return Interval(mean, mean - half, mean + half, len(finite))


def mean_band(curves: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the mean over runs, and the lower and upper end of its interval at each time, each shape (times,).

    Args:
        curves: shape (runs, times), without NaN.
    """
    runs = len(curves)
    mean: FloatArray = curves.mean(axis=0)
    half = curves.std(axis=0, ddof=1) * _width_per_deviation(runs) if runs > 1 else np.zeros_like(mean)
    return mean, mean - half, mean + half


def paired_differences(values: Mapping[str, FloatArray], reference: str) -> tuple[PairedDifference, ...]:
    """Compare every variant with the reference.

    Args:
        values: one number per initialisation for each variant, in the same order for all, NaN where it has not run.
        reference: a key of ``values``.

    Raises:
        KeyError: there is no such reference.
    """
    base = values[reference]
    variants = [name for name in values if name != reference]
    differences = [(values[name] - base)[np.isfinite(values[name] - base)] for name in variants]
    p_values = [_signed_rank(difference) for difference in differences]
    return tuple(
        PairedDifference(name, mean_interval(difference), _share_better(difference), p_value, corrected)
        for name, difference, p_value, corrected in zip(
            variants, differences, p_values, holm_correction(p_values), strict=True
        )
    )


def expected_calibration_error(probabilities: FloatArray, is_true: FloatArray, weights: FloatArray) -> float:
    """Return the expected calibration error: the difference of probability and truth, averaged over ranges.

    Args:
        probabilities: what was stated, 0 to 1, shape (n,).
        is_true: 1 where it was so, else 0, shape (n,).
        weights: what each counts, with a sum of 1, shape (n,).
    """
    bins = np.minimum((probabilities * _CALIBRATION_BINS).astype(np.intp), _CALIBRATION_BINS - 1)
    return float(np.abs(np.bincount(bins, weights * (probabilities - is_true))).sum())


def holm_correction(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for their number.

    Source: Holm, *A simple sequentially rejective multiple test procedure*, Scandinavian Journal of Statistics 6, 1979.
    """
    corrected = np.empty(len(p_values))
    largest = 0.0
    for rank, index in enumerate(np.argsort(p_values)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        corrected[index] = largest
    return [float(value) for value in corrected]


@cache
def _width_per_deviation(runs: int) -> float:
    """Half the interval's width over the standard deviation."""
    # A second to import, which only what computes intervals and tests should pay, here and below.
    from scipy import stats  # noqa: PLC0415

    return float(stats.t.ppf((1.0 + CONFIDENCE) / 2.0, runs - 1)) / math.sqrt(runs)


def _share_better(difference: FloatArray) -> float:
    return float(np.mean(np.heaviside(difference, 0.5))) if len(difference) else math.nan


def _signed_rank(difference: FloatArray) -> float:
    if not difference.any():
        return 1.0
    from scipy import stats  # noqa: PLC0415

    return float(stats.wilcoxon(difference).pvalue)
