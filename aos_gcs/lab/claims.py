"""Tests of the AOS-APSO paper's claims on the runs of a campaign.

Every function returns what was measured and whether the claim holds here, by a rule that its docstring states; the
rules were written down before the campaigns were run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.experiment import closest_approach_m
from aos_gcs.lab.report import Comparison
from aos_gcs.lab.runs import Run
from aos_gcs.lab.statistics import Interval, mean_interval
from aos_gcs.swarm.line import line_by_index, line_by_projection

FloatArray = NDArray[np.float64]

AOS_PSO, STABILISED = "aos-pso(projection_line=true)", "aos-pso-stabilised(projection_line=true)"
TUNED, UNTUNED = "aos-apso-paper", "aos-apso-untuned"
PAPER_STRATEGIES = (AOS_PSO, STABILISED, TUNED, UNTUNED)
"""The paper's four: AOS-PSO has the projection-based line there, too."""

NOT_WORSE_BY = 0.05
"""Loss of visibility that still counts as no worse."""
TINY_SHARE = 0.2
"""Share of c4 below which the sum of social and cognitive factor counts as tiny."""
CENTRED = 0.1
"""Evolutionary factor below which the swarm keeps its area (section Exact positions matter)."""


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim of the paper and what became of it."""

    text: str
    measured: str
    holds: bool


def plateau(comparison: Comparison) -> Claim:
    """AOS-PSO levels off near 0.4: from 8 s on it changes by less than 0.1, and its mean lies within 0.3 to 0.5."""
    times_s = comparison.times_s
    curves = comparison.curves("visibility")[AOS_PSO]
    late = mean_interval(curves[:, times_s >= 8.0].mean(axis=1))
    change = mean_interval(curves[:, times_s >= 17.0].mean(axis=1) - _between(curves, times_s, 8.0, 11.0))
    return Claim(
        "AOS-PSO rises quickly and stagnates near a visibility of 0.4",
        f"mean from 8 s on {_shown(late)}; change from 8-11 s to 17-20 s {_shown(change)}",
        0.3 <= late.mean <= 0.5 and abs(change.mean) < 0.1,
    )


def stabilisation_centres(comparison: Comparison) -> Claim:
    """Leader stabilisation lowers e_f: the paired difference of its mean lies below 0, with its whole interval."""
    difference = mean_interval(_mean_factor(comparison, STABILISED) - _mean_factor(comparison, AOS_PSO))
    plain = mean_interval(_mean_factor(comparison, AOS_PSO))
    return Claim(
        "Leader stabilisation lowers the evolutionary factor",
        f"AOS-PSO {_shown(plain)}; paired difference {_shown(difference)}",
        difference.high < 0.0,
    )


def stabilisation_is_no_worse(comparison: Comparison) -> Claim:
    """Test that the loss is at most 0.05, by the lower end of the paired difference."""
    difference = _visibility_gain(comparison, STABILISED)
    return Claim(
        "Leader-stabilised AOS-PSO is no worse than AOS-PSO",
        f"paired difference of V {_shown(difference)}",
        difference.low > -NOT_WORSE_BY,
    )


def tuned_gains(comparison: Comparison) -> Claim:
    """A tendency: the mean paired difference lies above 0, whatever its interval."""
    difference = _visibility_gain(comparison, TUNED)
    return Claim(
        "Tuned AOS-APSO tends to improve over AOS-PSO",
        f"paired difference of V {_shown(difference)}",
        difference.mean > 0.0,
    )


def untuned_loses(comparison: Comparison) -> Claim:
    """A tendency: the mean paired difference lies below 0, whatever its interval."""
    difference = _visibility_gain(comparison, UNTUNED)
    return Claim(
        "Untuned AOS-APSO tends to underperform AOS-PSO",
        f"paired difference of V {_shown(difference)}",
        difference.mean < 0.0,
    )


def tiny_factors_explode(comparison: Comparison) -> Claim:
    """Test that the swarm grows where both factors are tiny, and more than elsewhere, by intervals over the runs."""
    growth = [_growth(run, comparison.scenario.spacing_m) for run in comparison.of(TUNED)]
    tiny, other = (mean_interval(np.array(values)) for values in zip(*growth, strict=True))
    if tiny.count < 2:
        measured = f"both factors together fall below {TINY_SHARE:g} c4 in {tiny.count} of {len(growth)} runs"
        return Claim("The swarm explodes when both factors get tiny", measured, holds=False)
    return Claim(
        "The swarm explodes when both factors get tiny",
        f"growth of the radius per step {_shown(tiny)} m where c_s + c_c < {TINY_SHARE:g} c4 "
        f"(in {tiny.count} of {len(growth)} runs), {_shown(other)} m elsewhere",
        tiny.low > max(0.0, other.high),
    )


def positions_matter(comparison: Comparison) -> Claim:
    """While e_f stays low, V changes from step to step at least half as much as otherwise."""
    changes = [_changes(run) for run in comparison.of(TUNED)]
    centred, other = (mean_interval(np.array(values)) for values in zip(*changes, strict=True))
    return Claim(
        "Exact positions matter, even while the swarm keeps its area",
        f"root mean square change of V per step {_shown(centred)} while e_f < {CENTRED:g}, {_shown(other)} otherwise",
        centred.mean >= 0.5 * other.mean,
    )


def projection_lines(rng: np.random.Generator, swarms: int = 500) -> tuple[Claim, Claim]:
    """Test of random swarms that form the line by projection and by index.

    Shorter: the total way is, with its whole interval. Crossing-free: no two ways have a point in common.
    """
    ratios, nearest_m, crossings, crossings_by_index = [], np.inf, 0, 0
    for _ in range(swarms):
        positions_m = rng.normal(0.0, 8.0, (10, 2))
        direction = rng.normal(size=2)
        projected = line_by_projection(positions_m, direction, 4.2)
        indexed = line_by_index(positions_m, direction, 4.2)
        ratios.append(_total_m(positions_m, projected) / _total_m(positions_m, indexed))
        crossings += _crossings(positions_m, projected)
        crossings_by_index += _crossings(positions_m, indexed)
        # Where two begin near to each other they are near, whatever the line.
        begin_m = closest_approach_m(positions_m, positions_m)
        nearest_m = min(nearest_m, closest_approach_m(positions_m, projected) / begin_m)
    ratio = mean_interval(np.array(ratios))
    return (
        Claim(
            "Projection-based line positions shorten paths",
            f"{swarms} random swarms of 10: total way {_shown(ratio)} of that by index",
            ratio.high < 1.0,
        ),
        Claim(
            "Paths to projection-based line positions never cross",
            f"{crossings} crossings, {crossings_by_index} by index; drones that start and arrive together keep their "
            f"order along the line and never meet: they come no nearer than {nearest_m:.2f} times the smallest "
            "distance at the start",
            crossings == 0,
        ),
    )


def paper_claims(comparison: Comparison) -> tuple[Claim, ...]:
    """Put all claims to the test, on a campaign of :data:`PAPER_STRATEGIES`."""
    return (
        plateau(comparison),
        stabilisation_centres(comparison),
        stabilisation_is_no_worse(comparison),
        tuned_gains(comparison),
        untuned_loses(comparison),
        tiny_factors_explode(comparison),
        positions_matter(comparison),
        *projection_lines(np.random.default_rng(0)),
    )


def _between(curves: FloatArray, times_s: FloatArray, start_s: float, end_s: float) -> FloatArray:
    return np.asarray(curves[:, (times_s >= start_s) & (times_s <= end_s)].mean(axis=1))


def _mean_factor(comparison: Comparison, strategy: str) -> FloatArray:
    return np.array([np.nanmean(run.column("evolutionary_factor")) for run in comparison.of(strategy)])


def _visibility_gain(comparison: Comparison, strategy: str) -> Interval:
    values = comparison.metrics
    return mean_interval(values[strategy]["visibility_mean"] - values[AOS_PSO]["visibility_mean"])


def _growth(run: Run, c4_m: float) -> tuple[float, float]:
    """Return by how much the swarm's radius grows per step, in metres: after steps of tiny factors, and of others."""
    positions_m = run.trace().positions_enu_m
    radius_m = np.linalg.norm(positions_m - positions_m.mean(axis=1, keepdims=True), axis=-1).mean(axis=1)
    factors_m = (run.column("c_s_m") + run.column("c_c_m"))[:-1]
    growth_m = np.diff(radius_m)
    return _mean(growth_m[factors_m < TINY_SHARE * c4_m]), _mean(growth_m[factors_m >= TINY_SHARE * c4_m])


def _changes(run: Run) -> tuple[float, float]:
    """Return the root mean square change of V from step to step: while e_f is low, and otherwise."""
    factor = run.column("evolutionary_factor")
    squares = np.diff(run.column("visibility")) ** 2
    known = np.isfinite(factor[:-1]) & np.isfinite(factor[1:])
    centred = known & (np.fmax(factor[:-1], factor[1:]) < CENTRED)
    return float(np.sqrt(_mean(squares[centred]))), float(np.sqrt(_mean(squares[known & ~centred])))


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else np.nan


def _total_m(start_m: FloatArray, end_m: FloatArray) -> float:
    return float(np.linalg.norm(end_m - start_m, axis=1).sum())


def _crossings(start_m: FloatArray, end_m: FloatArray) -> int:
    """Return how many pairs of straight ways cross, of n ways, each shape (n, 2)."""
    first, second = np.triu_indices(len(start_m), k=1)
    a, b, c, d = start_m[first], end_m[first], start_m[second], end_m[second]
    apart = _side(a, b, c) * _side(a, b, d) < 0.0
    return int(np.count_nonzero(apart & (_side(c, d, a) * _side(c, d, b) < 0.0)))


def _side(a: FloatArray, b: FloatArray, point: FloatArray) -> FloatArray:
    """Return on which side of the lines a to b points lie, by the sign."""
    along, offset = b - a, point - a
    return np.asarray(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0])


def _shown(interval: Interval) -> str:
    return f"{interval.mean:.3f} ({interval.low:.3f} to {interval.high:.3f})"
