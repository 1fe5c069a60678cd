"""The tiles of a survey on several processes of this machine, one thread each."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import cv2

from aos_gcs.errors import LinkError
from aos_gcs.imaging.workers import use_one_thread
from aos_gcs.surveys.integration import Advance, TileResult, Work, integrate_tiles
from aos_gcs.surveys.tiles import Tile, grouped

GROUPS_PER_PROCESS = 1
"""Number of groups of tiles: more would balance the work, but an image is read once for every group that sees it."""

REPORT_INTERVAL_S = 0.5
"""Time between two reports of what is done."""


@dataclass(slots=True)
class _Shared:
    """Data that the processes share."""

    work: Work
    done: Any
    """Number of images that are done, a shared integer."""
    is_stopped: Any
    """Event: results are not wanted any more."""


_shared: list[_Shared] = []
"""Shared data of this process, if it is one of the workers."""


def integrate_in_processes(
    processes: int, work: Work, groups: Sequence[Sequence[Tile]], advance: Advance
) -> Iterator[list[TileResult]]:
    """Integrate groups of tiles; they come in the order in which they are done.

    Args:
        processes: number of processes.
        work: settings that all tiles share.
        groups: see :func:`process_groups`.
        advance: called with the number of further images that are done, one for each group that sees it.

    Raises:
        AosError: as :func:`~aos_gcs.surveys.integration.integrate_tiles`; also if a process is lost.
    """
    # Forked processes would lack the threads that OpenCV and BLAS count on.
    context = get_context("spawn")
    shared = _Shared(work, context.Value("L", 0), context.Event())
    with ProcessPoolExecutor(min(processes, len(groups)), context, _begin, (shared,)) as pool:
        pending: set[Future[list[TileResult]]] = {pool.submit(_integrate, group) for group in groups}
        reported = 0
        try:
            while pending:
                done, pending = wait(pending, REPORT_INTERVAL_S, FIRST_COMPLETED)
                reported, before = int(shared.done.value), reported
                advance(reported - before)
                for future in done:
                    yield future.result()
        except BrokenProcessPool as error:
            raise LinkError(
                "A process was lost while it integrated: use fewer --jobs or a smaller --max-memory, so that all of "
                "them fit into the memory."
            ) from error
        finally:
            shared.is_stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)


def process_groups(processes: int, work: Work, tiles: Sequence[Tile]) -> list[list[Tile]]:
    """Return the groups of tiles that processes compute one at a time."""
    return grouped(tiles, work.cell_bytes, work.max_bytes, GROUPS_PER_PROCESS * processes)


class _StoppedError(Exception):
    """The results are not wanted any more."""


def _begin(shared: _Shared) -> None:
    # Ctrl+C reaches all processes of a terminal; the first one stops the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    use_one_thread()
    _shared.append(shared)


def _integrate(tiles: Sequence[Tile]) -> list[TileResult]:
    shared = _shared[-1]

    def advance(units: int) -> None:
        if shared.is_stopped.is_set():
            raise _StoppedError
        with shared.done.get_lock():
            shared.done.value += units

    return integrate_tiles(shared.work, tiles, advance)
