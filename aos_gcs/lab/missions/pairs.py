"""Two strategies on the same missions: differences of what they claimed and cost, pair by pair."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.errors import InputDataError
from aos_gcs.lab.missions.model import MissionResult
from aos_gcs.lab.report import markdown_table
from aos_gcs.lab.statistics import Interval, PairedDifference, holm_correction, paired_differences


@dataclass(frozen=True, slots=True)
class PairedFigure:
    """Difference of one figure, over the missions in which both strategies have it."""

    title: str
    digits: int
    """Decimal places of the figure."""
    reference_mean: float
    """NaN without a pair."""
    difference: Interval
    """Mean of the strategy minus the reference."""
    p_corrected: float
    """Wilcoxon signed-rank test with Holm's correction for the number of figures."""


def _of_persons(value: Callable[[MissionResult], float]) -> Callable[[MissionResult], float]:
    """Return the figure of missions with a person; NaN for the others."""
    return lambda result: value(result) if result.persons else math.nan


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else math.nan


FIGURES: tuple[tuple[str, int, Callable[[MissionResult], float]], ...] = (
    ("persons found, share", 2, _of_persons(lambda one: one.persons_found / one.persons)),
    ("false claims", 2, lambda one: one.claims - one.true_claims),
    ("position error, m, where both find the person", 2, lambda one: _mean(one.errors_m)),
    ("time to a person's claim, s, where both find the person", 0, lambda one: _mean(one.claimed_after_s)),
    ("false convergences", 1, lambda one: one.false_convergences),
    ("minutes they cost", 2, lambda one: one.false_convergence_s / 60.0),
    ("duration, min", 2, lambda one: one.duration_s / 60.0),
    ("smallest separation, m", 2, lambda one: math.nan if one.min_separation_m is None else one.min_separation_m),
)
"""Title, decimal places and value of each figure of a mission; the value is NaN where a mission has none."""

_SIDES = ("strategy", "reference")


def pair_missions(results: Iterable[MissionResult], references: Iterable[MissionResult]) -> tuple[PairedFigure, ...]:
    """Compare the missions that two strategies have both flown.

    Args:
        results: missions of the strategy.
        references: those of the strategy that it is compared with.

    Raises:
        InputDataError: they have no mission in common.
    """
    by_key = {one.key: one for one in references}
    pairs = [(one, by_key[one.key]) for one in results if one.key in by_key]
    if not pairs:
        raise InputDataError("There is nothing to compare: the reference has flown none of these missions.")
    compared = [_compared(value, pairs) for _, _, value in FIGURES]
    corrected = holm_correction([paired.p_value for _, paired in compared])
    return tuple(
        PairedFigure(title, digits, mean, paired.difference, p_value)
        for (title, digits, _), (mean, paired), p_value in zip(FIGURES, compared, corrected, strict=True)
    )


def _compared(
    value: Callable[[MissionResult], float], pairs: Sequence[tuple[MissionResult, MissionResult]]
) -> tuple[float, PairedDifference]:
    """Return the mean of a figure of the reference, and the difference to it, over the pairs that both have it."""
    values = {name: np.array([value(pair[side]) for pair in pairs], float) for side, name in enumerate(_SIDES)}
    (paired,) = paired_differences(values, _SIDES[1])
    base = values[_SIDES[1]][np.isfinite(values[_SIDES[0]] - values[_SIDES[1]])]
    return (float(base.mean()) if len(base) else math.nan), paired


def pairs_as_markdown(figures: Sequence[PairedFigure], strategy: str, reference: str) -> str:
    """Return a table of the differences."""
    rows = (
        [
            one.title,
            str(one.difference.count),
            _number(one.reference_mean, one.digits),
            _number(one.reference_mean + one.difference.mean, one.digits),
            _interval(one),
            f"{one.p_corrected:.2g}" if one.difference.count else "-",
        ]
        for one in figures
    )
    return markdown_table(["per mission", "pairs", reference, strategy, "difference", "p, corrected"], rows) + "\n"


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _interval(figure: PairedFigure) -> str:
    difference, digits = figure.difference, figure.digits
    if not difference.count:
        return "-"
    text = f"{difference.mean:+.{digits}f}"
    if not math.isfinite(difference.half_width):
        return text
    return f"{text} ({difference.low:+.{digits}f} to {difference.high:+.{digits}f})"
