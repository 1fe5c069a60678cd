"""The laboratory's figures: arrays in, matplotlib figures out.

Colours are Okabe and Ito's, which colour-blind readers tell apart; every variant keeps its own throughout a report.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.runs import Trace
from aos_gcs.lab.statistics import Interval, mean_band

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D1F")
STATE_MARKERS = {"exploration": "^", "exploitation": "s", "convergence": "o", "jumping_out": "D"}
FORMATS = ("png", "svg")
DPI = 150
TARGET_COLOUR = "#CC00CC"
GRID_COLOUR = "0.9"
LABEL_WIDTH = 26
HISTOGRAM_BINS = np.linspace(0.0, 1.0, 21)


@dataclass(frozen=True, slots=True)
class PublishedResult:
    """A published result to compare with: a value at a time."""

    label: str
    time_s: float
    value: float


def colours(names: Sequence[str]) -> dict[str, str]:
    """Return one colour per variant."""
    return dict(zip(names, itertools.cycle(PALETTE), strict=False))


def curves(
    time_s: FloatArray,
    runs: Mapping[str, FloatArray],
    *,
    ylabel: str,
    palette: Mapping[str, str],
    top: float | None = None,
    bound: Interval | None = None,
    marks: Sequence[PublishedResult] = (),
) -> Figure:
    """Mean curves over runs with their 95 % confidence bands.

    Args:
        time_s: common times, shape (T,).
        runs: per variant, shape (runs, T).
        ylabel: quantity of the curves.
        palette: see :func:`colours`.
        top: the greatest value that they can have, if there is one.
        bound: the oracle's value, if the report has one.
        marks: published results.
    """
    figure, axes = _figure_with_axes(8.0, 4.2)
    for name, values in runs.items():
        mean, low, high = mean_band(values)
        axes.plot(time_s, mean, color=palette[name], label=_wrapped(name), linewidth=1.8)
        axes.fill_between(time_s, low, high, color=palette[name], alpha=0.18, linewidth=0)
    if bound is not None:
        axes.axhline(bound.mean, color="0.35", linestyle="--", linewidth=1.2, label="oracle")
        axes.axhspan(bound.low, bound.high, color="0.35", alpha=0.10, linewidth=0)
    for mark, symbol in zip(marks, itertools.cycle("xP*v"), strict=False):
        axes.plot(mark.time_s, mark.value, symbol, color="0.2", markersize=7, linestyle="none", label=mark.label)
    axes.set(xlabel="simulated time / s", ylabel=ylabel, xlim=(0.0, float(time_s[-1])))
    axes.set_ylim(0.0, top)
    _legend_beside(axes)
    return figure


def differences(intervals: Mapping[str, Interval], *, xlabel: str, palette: Mapping[str, str]) -> Figure:
    """Paired differences to the reference, one line per variant, with their confidence intervals."""
    figure, axes = _figure_with_axes(7.0, 1.2 + 0.5 * len(intervals))
    for row, (name, interval) in enumerate(list(intervals.items())[::-1]):
        axes.errorbar(
            interval.mean,
            row,
            xerr=[[interval.mean - interval.low], [interval.high - interval.mean]],
            fmt="o",
            color=palette[name],
            capsize=4,
        )
    axes.axvline(0.0, color="0.35", linewidth=1.0)
    axes.set_yticks(range(len(intervals)), [_wrapped(name) for name in list(intervals)[::-1]])
    axes.set_ylim(-0.6, len(intervals) - 0.4)
    axes.set_xlabel(xlabel)
    return figure


def histograms(factors: Mapping[str, FloatArray], *, palette: Mapping[str, str]) -> Figure:
    """Histogram of the evolutionary factors, one panel per variant; NaN values are left out."""
    columns = min(len(factors), 4)
    rows = -(-len(factors) // columns)
    figure = _figure(2.6 * columns, 2.3 * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, (name, values) in zip(grid.flat, factors.items(), strict=False):
        finite = values[np.isfinite(values)]
        weights = np.full(len(finite), 1.0 / max(len(finite), 1))
        axes.hist(finite, bins=HISTOGRAM_BINS, weights=weights, color=palette[name])
        axes.set_title(f"{_wrapped(name)}\nmean {finite.mean():.2f}" if len(finite) else _wrapped(name), fontsize=8)
        axes.grid(axis="y", color=GRID_COLOUR)
        axes.set_axisbelow(True)
    for axes in grid.flat[len(factors) :]:
        axes.set_visible(False)
    figure.supxlabel("evolutionary factor", fontsize=9)
    figure.supylabel("share of steps", fontsize=9)
    return figure


def trajectories(trace: Trace, *, title: str) -> Figure:
    """Paths of the drones from above, coloured by time from dark to light; a star marks the leader of each step."""
    from matplotlib import colormaps  # noqa: PLC0415 - see _figure
    from matplotlib.cm import ScalarMappable  # noqa: PLC0415
    from matplotlib.collections import LineCollection  # noqa: PLC0415
    from matplotlib.colors import Normalize  # noqa: PLC0415
    from matplotlib.lines import Line2D  # noqa: PLC0415

    figure = _figure(6.4, 5.6)
    axes = figure.subplots()
    followers, leaders = colormaps["viridis"], colormaps["autumn"]
    steps = len(trace.time_s)
    share = np.linspace(0.0, 0.95, steps)
    for drone in range(trace.positions_enu_m.shape[1]):
        path = trace.positions_enu_m[:, drone]
        segments = LineCollection(list(np.stack([path[:-1], path[1:]], axis=1)), colors=followers(share[:-1]))
        segments.set(linewidth=0.7, alpha=0.7)
        axes.add_collection(segments)
        axes.scatter(path[:, 0], path[:, 1], c=followers(share), s=9, zorder=2)
    led = [step for step, row in enumerate(trace.leader) if row is not None]
    places = np.array([trace.positions_enu_m[step, trace.leader[step]] for step in led]).reshape(-1, 2)
    axes.scatter(
        places[:, 0], places[:, 1], c=leaders(share[led]), marker="*", s=70, zorder=3, edgecolors="0.3", linewidths=0.3
    )
    axes.plot(*trace.target_enu_m.T, color=TARGET_COLOUR, linewidth=1.0, zorder=3)
    axes.plot(*trace.target_enu_m[-1], "P", color=TARGET_COLOUR, markersize=9, markeredgecolor="white", zorder=4)
    around = np.concatenate([trace.positions_enu_m.reshape(-1, 2), trace.target_enu_m])
    low, high = around.min(axis=0) - 3.0, around.max(axis=0) + 3.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="east / m", ylabel="north / m")
    axes.set_title(title, fontsize=9)
    times = Normalize(float(trace.time_s[0]), float(trace.time_s[-1]))
    scale = figure.colorbar(ScalarMappable(times, followers), ax=axes, shrink=0.8)
    scale.set_label("simulated time / s")
    axes.legend(
        handles=[
            Line2D([], [], marker="o", linestyle="none", color=followers(0.5), markersize=4, label="drone"),
            Line2D([], [], marker="*", linestyle="none", color=leaders(0.5), markersize=9, label="leader"),
            Line2D([], [], marker="P", linestyle="none", color=TARGET_COLOUR, markersize=7, label="target"),
        ],
        fontsize=8,
        loc="best",
    )
    return figure


def run_panel(trace: Trace, *, title: str, colour: str) -> Figure:
    """One run: visibility, evolutionary factor with the state as the marker's shape, social and cognitive factor."""
    has_factors = bool(np.isfinite(trace.c_s).any())
    figure = _figure(7.0, 5.4 if has_factors else 3.8)
    panels = figure.subplots(3 if has_factors else 2, 1, sharex=True)
    panels[0].plot(trace.time_s, trace.visibility, color=colour)
    panels[0].set(ylabel="visibility", ylim=(0.0, 1.0))
    panels[0].set_title(title, fontsize=9)
    panels[1].plot(trace.time_s, trace.evolutionary_factor, color="0.6", linewidth=0.8)
    states = np.array([state or "" for state in trace.evolutionary_state])
    for state, marker in STATE_MARKERS.items():
        now = states == state
        if now.any():
            panels[1].plot(trace.time_s[now], trace.evolutionary_factor[now], marker, markersize=4, label=state)
    if not (states != "").any():
        panels[1].plot(trace.time_s, trace.evolutionary_factor, ".", color="0.3", markersize=4)
    panels[1].set(ylabel="evolutionary\nfactor", ylim=(0.0, 1.0))
    if has_factors:
        panels[2].plot(trace.time_s, trace.c_s, label="social", color=PALETTE[0])
        panels[2].plot(trace.time_s, trace.c_c, label="cognitive", color=PALETTE[1])
        panels[2].set_ylabel("factor / m")
        panels[2].set_ylim(bottom=0.0)
    for axes in panels:
        axes.grid(color=GRID_COLOUR)
        if axes.get_legend_handles_labels()[0]:
            _legend_beside(axes)
    panels[-1].set_xlabel("simulated time / s")
    return figure


def distributions(values: Mapping[str, FloatArray], *, xlabel: str, palette: Mapping[str, str]) -> Figure:
    """Distribution of one number per run: box, median and every run, one line per variant."""
    figure, axes = _figure_with_axes(7.0, 1.2 + 0.5 * len(values))
    names = list(values)[::-1]
    rng = np.random.default_rng(0)
    for row, name in enumerate(names):
        finite = values[name][np.isfinite(values[name])]
        if not len(finite):
            continue
        axes.boxplot(finite, positions=[row], orientation="horizontal", widths=0.6, showfliers=False)
        axes.plot(finite, row + rng.uniform(-0.2, 0.2, len(finite)), ".", color=palette[name], alpha=0.5, markersize=5)
    axes.set_yticks(range(len(names)), [_wrapped(name) for name in names])
    axes.set_ylim(-0.6, len(names) - 0.4)
    axes.set_xlabel(xlabel)
    return figure


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write a figure as PNG and SVG; the same data give the same files."""
    for suffix in FORMATS:
        metadata = {"Date": None} if suffix == "svg" else {"Software": None}
        figure.savefig(folder / f"{name}.{suffix}", dpi=DPI, metadata=metadata)


def _figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure; Matplotlib is imported with the first one, since it takes longer than the other work."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    return Figure(figsize=(width_in, height_in), layout="constrained")


def _figure_with_axes(width_in: float, height_in: float) -> tuple[Figure, Axes]:
    figure = _figure(width_in, height_in)
    axes = figure.subplots()
    axes.grid(color=GRID_COLOUR)
    axes.set_axisbelow(True)
    return figure, axes


def _wrapped(name: str) -> str:
    """Return a variant's name in lines short enough for an axis or a title; its parameters begin a line."""
    lines = wrap(name.replace("(", " (", 1), LABEL_WIDTH, break_on_hyphens=False, break_long_words=False)
    return "\n".join(lines)


def _legend_beside(axes: Axes) -> None:
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0)
