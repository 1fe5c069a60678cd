"""Computation of ``aos-gcs integrate``: options for averaging, memory, processes and machines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.output import progress
from aos_gcs.cluster import check_jobs, remote_cluster
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.trimmed import MEDIAN
from aos_gcs.surveys.cluster import integrate_on_cluster
from aos_gcs.surveys.integration import TileResult, Work, integrate_tiles, seen_images
from aos_gcs.surveys.processes import Processes, open_processes
from aos_gcs.surveys.rasters import SurveyRasters, assemble
from aos_gcs.surveys.tiles import RasterTile, grouped

AVERAGE_PANEL = "Averaging"
PANEL = "Computation"

DEFAULT_MAX_MEMORY_MB = 1000
MIN_MEMORY_MB = 50

Exact = Annotated[
    bool,
    typer.Option(
        "--exact/--fast",
        help="Double precision in place of single precision: 20 times slower, and less than 0.01 grey levels apart.",
        rich_help_panel=AVERAGE_PANEL,
    ),
]
Median = Annotated[
    bool,
    typer.Option(
        "--median", help="Median of each pixel's values instead of their mean.", rich_help_panel=AVERAGE_PANEL
    ),
]
Trim = Annotated[
    float | None,
    typer.Option(
        metavar="SHARE",
        help="Share of the largest and of the smallest values that the mean leaves out, 0 to 0.5.",
        rich_help_panel=AVERAGE_PANEL,
    ),
]
MaxMemory = Annotated[
    int,
    typer.Option(
        metavar="MB",
        help="Memory of each process for values and sums, besides one image; larger work is divided.",
        rich_help_panel=PANEL,
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        help="Number of processes that compute the tiles of a map, one thread each; by default one, on all cores.",
        callback=check_jobs,
        rich_help_panel=PANEL,
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Dask scheduler whose workers compute the tiles of a map, for example tcp://host:8786. They read the "
        "images from the same paths.",
        rich_help_panel=PANEL,
    ),
]


@dataclass(frozen=True, slots=True)
class WorkOptions:
    """Values of the options for the computation.

    Raises:
        ConfigurationError: if a value lies outside its range, or options exclude each other.
    """

    median: bool
    trim: float | None
    max_memory_mb: int
    jobs: int | None
    scheduler: str | None
    processes: Processes | None = None
    """Processes that have been started for the jobs."""

    def __post_init__(self) -> None:
        if self.median and self.trim is not None:
            raise ConfigurationError("--median and --trim exclude each other: the median is the trim 0.5.")
        if self.trim is not None and not 0.0 <= self.trim <= MEDIAN:
            raise ConfigurationError(f"--trim must lie between 0 and 0.5, got {self.trim:g}.")
        if self.max_memory_mb < MIN_MEMORY_MB:
            raise ConfigurationError(f"--max-memory must be at least {MIN_MEMORY_MB} MB, got {self.max_memory_mb}.")
        if self.jobs is not None and self.scheduler is not None:
            raise ConfigurationError("--jobs and --scheduler exclude each other: a scheduler has workers of its own.")

    def check_map(self, ortho: float | None) -> None:
        """Refuse to divide a view among processes.

        Raises:
            ConfigurationError: if several processes are asked for what is not a map.
        """
        if ortho is None and (self.jobs is not None or self.scheduler is not None):
            name = "--jobs" if self.jobs is not None else "--scheduler"
            raise ConfigurationError(f"{name} divides the tiles of a map: request one with --ortho RES.")

    @contextmanager
    def begun(self, *, on_terrain: bool) -> Iterator[WorkOptions]:
        """Start the processes of the jobs, which get ready while the recording is read, and return the same options."""
        if self.jobs is None:
            yield self
            return
        with open_processes(self.jobs, ("scipy.ndimage",) if on_terrain else ()) as processes:
            yield replace(self, processes=processes)

    @property
    def share_left_out(self) -> float | None:
        """Share of a pixel's values left out at either end; None: plain mean."""
        return MEDIAN if self.median else self.trim

    def integrate(self, work: Work, tiles: Sequence[RasterTile], shape: tuple[int, int], folder: Path) -> SurveyRasters:
        """Integrate tiles and put them together, with a progress bar.

        Args:
            work: data and settings that the tiles have in common.
            tiles: parts of the raster.
            shape: shape of the whole raster.
            folder: place of temporary files for rasters too large for the memory.

        Raises:
            AosError: see :func:`~aos_gcs.surveys.integration.integrate_tiles`.
        """
        with self._results(work, tiles) as results:
            return assemble(work, shape, results, folder)

    @contextmanager
    def _results(self, work: Work, tiles: Sequence[RasterTile]) -> Iterator[Iterator[list[TileResult]]]:
        if self.processes is not None:
            groups = self.processes.groups(work, tiles)
            with progress("Integrating images", sum(len(seen_images(group)) for group in groups)) as advance:
                yield self.processes.integrate(work, groups, advance)
            return
        if self.scheduler is None:
            groups = grouped(tiles, work.cell_bytes, work.max_bytes)
            with progress("Integrating images", sum(len(seen_images(group)) for group in groups)) as advance:
                yield (integrate_tiles(work, group, advance) for group in groups)
            return
        with remote_cluster(self.scheduler or "") as client, progress("Integrating tiles", len(tiles)) as advance:
            yield integrate_on_cluster(client, work, tiles, advance)
