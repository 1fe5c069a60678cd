"""Rows of a campaign in the form that statistics and figures want: curves on common times, numbers per run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GRID_S = 0.25
"""Interval of the common times; a step of the paper's time model takes 0.1 to 0.4 s."""
SETTLED_S = 5.0
"""Time from which means are taken: by then the swarm has reached the target."""
LOOK_S = 14.0
"""Time at which [N] and the study of strategies compare."""


@dataclass(frozen=True, slots=True)
class RunMetrics:
    """Key figures of one run; NaN where a figure does not exist."""

    visibility_mean: float
    """V of current frames, mean over time from ``SETTLED_S`` to the end."""
    visibility_look: float
    """V of current frames at ``LOOK_S``."""
    area_mean_m2: float
    """A of current frames, mean over time from ``SETTLED_S`` to the end."""
    history_look: float
    """V of all frames up to ``LOOK_S``."""
    detection_s: float
    """Time of the first step with the target in view."""
    path_m: float
    """Mean way flown by a drone."""
    min_distance_m: float
    """Smallest horizontal distance between two drones at the exposures."""
    min_flight_distance_m: float
    """The same in flight, had all arrived together."""
    position_error_m: float
    """Median over the steps with the target in view, from ``SETTLED_S`` on."""


METRICS = tuple(item.name for item in fields(RunMetrics))


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """History of one run, step by step; T steps, n drones."""

    time_s: FloatArray
    """Shape (T,)."""
    visibility: FloatArray
    """Normalised, shape (T,)."""
    evolutionary_factor: FloatArray
    """Shape (T,); NaN in steps without one."""
    evolutionary_state: Sequence[str | None]
    c_s: FloatArray
    """Social factor, as a share of c4 or as the strategy has it, shape (T,); NaN without one."""
    c_c: FloatArray
    """Cognitive factor, shape (T,)."""
    positions_enu_m: FloatArray
    """Shape (T, n, 2)."""
    leader: Sequence[int | None]
    """Row of the leader."""
    target_enu_m: FloatArray
    """True position, shape (T, 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """The rows of one run, in the order of its steps."""

    strategy: str
    initialisation: str
    table: pa.Table

    def column(self, name: str) -> FloatArray:
        """Return a column of numbers, NaN where a row has none, shape (steps,)."""
        return np.asarray(self.table[name].to_numpy(zero_copy_only=False), dtype=np.float64)

    def curve(self, name: str, grid_s: FloatArray) -> FloatArray:
        """Return a column, interpolated linearly at the given times, as the paper does."""
        return np.asarray(np.interp(grid_s, self.column("time_s"), self.column(name)))

    def metrics(self, duration_s: float) -> RunMetrics:
        """Return the numbers of the run."""
        times = common_times(duration_s)
        settled = times[times >= min(SETTLED_S, duration_s)]
        look = np.array([min(LOOK_S, duration_s)])
        time_s, in_view = self.column("time_s"), self.column("in_view") > 0
        errors = self.column("target_error_m")[(time_s >= settled[0]) & in_view]
        return RunMetrics(
            visibility_mean=float(self.curve("visibility", settled).mean()),
            visibility_look=float(self.curve("visibility", look)[0]),
            area_mean_m2=float(self.curve("area_m2", settled).mean()),
            history_look=float(self.curve("history_visibility", look)[0]),
            detection_s=float(time_s[in_view][0]) if in_view.any() else np.nan,
            path_m=float(self.column("path_m")[-1]),
            min_distance_m=float(self.column("min_distance_m").min()),
            min_flight_distance_m=float(self.column("min_flight_distance_m").min()),
            position_error_m=float(np.nanmedian(errors)) if np.isfinite(errors).any() else np.nan,
        )

    def trace(self) -> Trace:
        """Return what the figures of a single run show."""
        east_m, north_m = (np.array(self.table[name].to_pylist(), dtype=np.float64) for name in ("east_m", "north_m"))
        leaders = self.table["leader_id"].to_pylist()
        return Trace(
            time_s=self.column("time_s"),
            visibility=self.column("visibility"),
            evolutionary_factor=self.column("evolutionary_factor"),
            evolutionary_state=self.table["evolutionary_state"].to_pylist(),
            c_s=self.column("c_s_m"),
            c_c=self.column("c_c_m"),
            positions_enu_m=np.stack([east_m, north_m], axis=-1),
            leader=[None if leader is None else leader - 1 for leader in leaders],
            target_enu_m=np.stack([self.column("target_east_m"), self.column("target_north_m")], axis=-1),
        )


def common_times(duration_s: float) -> FloatArray:
    """Return the times at which curves are compared, shape (T,)."""
    return np.linspace(0.0, duration_s, max(2, round(duration_s / GRID_S) + 1))


def split_runs(table: pa.Table) -> Iterator[Run]:
    """Yield the runs of a campaign's rows, ordered by strategy and initialisation."""
    ordered = table.sort_by([("strategy", "ascending"), ("initialisation", "ascending"), ("step", "ascending")])
    starts = np.flatnonzero(pc.equal(ordered["step"], 1).to_numpy(zero_copy_only=False))
    for start, end in zip(starts, [*starts[1:], len(ordered)], strict=True):
        rows = ordered.slice(int(start), int(end - start))
        yield Run(rows["strategy"][0].as_py(), rows["initialisation"][0].as_py(), rows)
