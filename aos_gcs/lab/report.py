"""The report of a campaign: Markdown, figures (PNG and SVG) and the numbers behind them (CSV)."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.lab.bound import ORACLE
from aos_gcs.lab.figures import (
    PublishedResult,
    colours,
    curves,
    differences,
    distributions,
    histograms,
    run_panel,
    save,
    trajectories,
)
from aos_gcs.lab.runs import LOOK_S, METRICS, SETTLED_S, Run, RunMetrics, common_times, split_runs
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.statistics import Interval, PairedDifference, mean_interval, paired_differences

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

PUBLISHED = (
    PublishedResult("AOS-PSO, as published 2023", 14.0, 0.72),
    PublishedResult("parallel blind, as published 2023", 3.0, 0.19),
)
"""Nathan, Kurmi, Bimber, Communications Engineering 2:55 (2023): 300 trees/ha, frames of earlier steps kept."""

CURVES = {
    "visibility": "V of the current frames",
    "area_m2": "visible area of the current frames / m²",
    "history_visibility": "V of all frames so far",
}


@dataclass(frozen=True, slots=False)
class Comparison:
    """The runs of a campaign, side by side."""

    scenario: Scenario
    strategies: tuple[str, ...]
    """Labels, in the order of the campaign."""
    initialisations: tuple[str, ...]
    """Initialisations that all strategies have run."""
    runs: Mapping[tuple[str, str], Run]
    """Runs by strategy and initialisation, including the oracle's."""

    @cached_property
    def times_s(self) -> FloatArray:
        """The common times of the curves, shape (T,)."""
        return common_times(self.scenario.duration_s)

    @cached_property
    def metrics(self) -> dict[str, dict[str, FloatArray]]:
        """Strategy → metric → one number per initialisation."""
        table: dict[str, dict[str, FloatArray]] = {}
        for strategy in self.strategies:
            of_runs = [run.metrics(self.scenario.duration_s) for run in self.of(strategy)]
            table[strategy] = {name: np.array([getattr(each, name) for each in of_runs]) for name in METRICS}
        return table

    def of(self, strategy: str) -> list[Run]:
        """Return the runs of a strategy, one per initialisation."""
        return [self.runs[strategy, name] for name in self.initialisations]

    def curves(self, column: str) -> dict[str, FloatArray]:
        """Return a column at the common times, shape (runs, T), by strategy."""
        return {
            strategy: np.array([run.curve(column, self.times_s) for run in self.of(strategy)])
            for strategy in self.strategies
        }

    def oracle(self, column: str) -> FloatArray | None:
        """Return the oracle's mean over time per initialisation; None when the campaign has none."""
        found = [self.runs.get((ORACLE, name)) for name in self.initialisations]
        values = [run.column(column).mean() for run in found if run is not None]
        return np.array(values) if len(values) == len(self.initialisations) else None

    def against(self, reference: str, metric: str) -> tuple[PairedDifference, ...]:
        """Compare all strategies with one of them."""
        return paired_differences({name: values[metric] for name, values in self.metrics.items()}, reference)


def compare(scenario: Scenario, strategies: Sequence[str], rows: pa.Table) -> Comparison:
    """Arrange the rows of a campaign.

    Args:
        scenario: scenario of the campaign.
        strategies: labels, in the order in which they are reported.
        rows: table of :data:`aos_gcs.lab.tables.SCHEMA`.

    Raises:
        InputDataError: no initialisation has been run by all strategies.
    """
    runs = {(run.strategy, run.initialisation): run for run in split_runs(rows)}
    names = sorted({initialisation for _, initialisation in runs})
    complete = tuple(name for name in names if all((strategy, name) in runs for strategy in strategies))
    if not complete:
        raise InputDataError(
            "There is nothing to report: no initialisation has been finished by all strategies; "
            "run the campaign to its end."
        )
    return Comparison(scenario, tuple(strategies), complete, runs)


def write_report(comparison: Comparison, folder: Path, *, reference: str, shown_runs: int) -> Path:
    """Write the report of a campaign and return its Markdown file.

    Args:
        comparison: see :func:`compare`.
        folder: is made; files of an earlier report are replaced.
        reference: the strategy that others are compared with.
        shown_runs: number of initialisations whose trajectories and single runs are drawn.

    Raises:
        ConfigurationError: the reference is not among the strategies.
    """
    if reference not in comparison.strategies:
        raise ConfigurationError(
            f"The reference {reference!r} is not in the campaign; choose one of {', '.join(comparison.strategies)}."
        )
    folder.mkdir(parents=True, exist_ok=True)
    _write_numbers(comparison, folder)
    names = _draw(comparison, folder, reference)
    shown = comparison.initialisations[:shown_runs]
    names |= {title: file for name in shown for title, file in _draw_runs(comparison, folder, name).items()}
    text = "\n\n".join(
        [*_text(comparison, reference), *(f"## {title}\n\n![{title}]({file})" for title, file in names.items())]
    )
    path = folder / "report.md"
    path.write_text(text + "\n", encoding="utf-8")
    return path


def compared_metrics(duration_s: float) -> dict[str, str]:
    """Return the numbers that strategies are compared by, with what they are called in runs of that duration."""
    look_s, settled_s = min(LOOK_S, duration_s), min(SETTLED_S, duration_s)
    return {
        "visibility_mean": f"V, mean from {settled_s:g} s on",
        "area_mean_m2": f"A, mean from {settled_s:g} s on / m²",
        "history_look": f"V with history at {look_s:g} s",
    }


def distributed_metrics(duration_s: float) -> dict[str, str]:
    """Return the numbers whose distribution over the runs is shown, with what they are called."""
    return {
        "visibility_look": f"V of the current frames at {min(LOOK_S, duration_s):g} s",
        "detection_s": "time to the first detection / s",
        "path_m": "mean way of a drone / m",
        "min_distance_m": "smallest horizontal distance at the exposures / m",
        "position_error_m": "median position error / m",
    }


def summary_table(comparison: Comparison) -> str:
    """Return what every strategy reaches, as a Markdown table."""
    oracle = comparison.oracle("visibility")
    rows = []
    for strategy in comparison.strategies:
        values = comparison.metrics[strategy]
        detected = np.isfinite(values["detection_s"])
        rows.append(
            [
                strategy,
                _with_interval(mean_interval(values["visibility_mean"])),
                f"{values['visibility_look'].mean():.3f}",
                f"{np.percentile(values['visibility_look'], 10):.3f}",
                "-" if oracle is None else f"{values['visibility_look'].mean() / oracle.mean():.2f}",
                f"{values['area_mean_m2'].mean():.3f}",
                f"{values['history_look'].mean():.3f}",
                f"{100 * detected.mean():.0f} %, {_median(values['detection_s'], 1)} s",
                f"{values['path_m'].mean():.0f}",
                f"{values['min_distance_m'].min():.1f}",
                _median(values["position_error_m"], 2),
            ]
        )
    duration_s = comparison.scenario.duration_s
    compared, look = compared_metrics(duration_s), f"V at {min(LOOK_S, duration_s):g} s"
    header = ["strategy", compared["visibility_mean"], look, f"{look}, 10th percentile", "of the oracle's", "A / m²"]
    header += [compared["history_look"], "detected, median time", "way / m", "least distance / m", "position error / m"]
    return markdown_table(header, rows)


def difference_table(comparison: Comparison, reference: str) -> str:
    """Return the paired differences to the reference, as a Markdown table."""
    rows = []
    for metric, title in compared_metrics(comparison.scenario.duration_s).items():
        base = comparison.metrics[reference][metric].mean()
        rows += [
            [
                each.variant,
                title,
                _signed_interval(each.difference),
                f"{100 * each.difference.mean / base:+.0f} %" if base > 0.0 else "-",
                f"{100 * each.share_better:.0f} %",
                f"{each.p_corrected:.2g}",
            ]
            for each in comparison.against(reference, metric)
        ]
    header = ["strategy", "quantity", f"difference to {reference}", "relative", "ahead in", "p, corrected"]
    return markdown_table(header, rows)


def _text(comparison: Comparison, reference: str) -> Iterable[str]:
    count = len(comparison.initialisations)
    yield f"# {len(comparison.strategies)} strategies, {count} initialisations"
    yield markdown_table(
        ["field", "value"], [[name, str(value)] for name, value in asdict(comparison.scenario).items()]
    )
    yield (
        "V is the visible area of the target over what the same views would show without the forest, A the visible "
        "area. Intervals and bands hold the mean with 95 % confidence (Student). Differences are paired by "
        "initialisation; p is that of the Wilcoxon signed-rank test, corrected after Holm. Distances are horizontal: "
        "altitude layers separate the drones besides."
    )
    oracle = comparison.oracle("visibility")
    if oracle is not None:
        yield f"The oracle, which knows the forest, reaches V = {_with_interval(mean_interval(oracle))}."
    yield "## What they reach\n\n" + summary_table(comparison)
    if len(comparison.strategies) > 1:
        yield f"## Paired differences to {reference}\n\n" + difference_table(comparison, reference)


def _draw(comparison: Comparison, folder: Path, reference: str) -> dict[str, str]:
    """Draw what all runs together show; return title → file."""
    palette = colours(comparison.strategies)
    drawn: dict[str, tuple[str, Figure]] = {}
    for column, label in CURVES.items():
        oracle = None if column == "history_visibility" else comparison.oracle(column)
        drawn[f"Mean over time: {label}"] = (
            f"mean_{column}",
            curves(
                comparison.times_s,
                comparison.curves(column),
                ylabel=label,
                palette=palette,
                top=None if column == "area_m2" else 1.0,
                bound=None if oracle is None else mean_interval(oracle),
                marks=PUBLISHED if column == "history_visibility" else (),
            ),
        )
    if len(comparison.strategies) > 1:
        for metric, label in compared_metrics(comparison.scenario.duration_s).items():
            intervals = {each.variant: each.difference for each in comparison.against(reference, metric)}
            drawn[f"Paired differences: {label}"] = (
                f"difference_{metric}",
                differences(intervals, xlabel=f"{label}, minus {reference}", palette=palette),
            )
    factors = {
        strategy: np.concatenate([run.column("evolutionary_factor") for run in comparison.of(strategy)])
        for strategy in comparison.strategies
    }
    factors = {strategy: values for strategy, values in factors.items() if np.isfinite(values).any()}
    if factors:
        drawn["Evolutionary factors"] = ("evolutionary_factor", histograms(factors, palette=palette))
    for metric, label in distributed_metrics(comparison.scenario.duration_s).items():
        values = {strategy: comparison.metrics[strategy][metric] for strategy in comparison.strategies}
        drawn[f"Per run: {label}"] = (f"runs_{metric}", distributions(values, xlabel=label, palette=palette))
    return _save_all(drawn, folder)


def _draw_runs(comparison: Comparison, folder: Path, initialisation: str) -> dict[str, str]:
    """Draw the runs of one initialisation one by one; return title → file."""
    palette = colours(comparison.strategies)
    drawn: dict[str, tuple[str, Figure]] = {}
    for number, strategy in enumerate(comparison.strategies, start=1):
        trace = comparison.runs[strategy, initialisation].trace()
        title = f"{strategy}, initialisation {initialisation}"
        file = f"{initialisation}_{number}"
        drawn[f"Trajectories: {title}"] = (f"trajectories_{file}", trajectories(trace, title=title))
        drawn[f"Run: {title}"] = (f"run_{file}", run_panel(trace, title=title, colour=palette[strategy]))
    return _save_all(drawn, folder)


def _save_all(drawn: Mapping[str, tuple[str, Figure]], folder: Path) -> dict[str, str]:
    for name, figure in drawn.values():
        save(figure, folder, name)
    return {title: f"{name}.png" for title, (name, _) in drawn.items()}


def _write_numbers(comparison: Comparison, folder: Path) -> None:
    names = [item.name for item in fields(RunMetrics)]
    _write_csv(
        folder / "runs.csv",
        ["strategy", "initialisation", *names],
        [
            [strategy, initialisation, *(values[name][index] for name in names)]
            for strategy, values in comparison.metrics.items()
            for index, initialisation in enumerate(comparison.initialisations)
        ],
    )
    _write_csv(
        folder / "curves.csv",
        ["strategy", "quantity", "time_s", "mean", "low", "high"],
        [
            [strategy, column, time_s, interval.mean, interval.low, interval.high]
            for column in CURVES
            for strategy, values in comparison.curves(column).items()
            for time_s, interval in zip(comparison.times_s, map(mean_interval, values.T), strict=True)
        ],
    )


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([f"{cell:.6g}" if isinstance(cell, float) else cell for cell in row] for row in rows)


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells as Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def _with_interval(interval: Interval) -> str:
    return f"{interval.mean:.3f} ± {interval.half_width:.3f}"


def _signed_interval(interval: Interval) -> str:
    return f"{interval.mean:+.3f} ({interval.low:+.3f} to {interval.high:+.3f})"


def _median(values: FloatArray, digits: int) -> str:
    finite = values[np.isfinite(values)]
    return f"{np.median(finite):.{digits}f}" if len(finite) else "-"
