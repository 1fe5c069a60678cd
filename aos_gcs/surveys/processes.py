"""The tiles of a survey on several processes of this machine, one thread each."""

from __future__ import annotations

import importlib
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context, reduction
from typing import Any

import cv2

from aos_gcs.errors import LinkError
from aos_gcs.imaging.workers import use_one_thread
from aos_gcs.surveys.integration import Advance, TileResult, Work, integrate_tiles
from aos_gcs.surveys.shared_reading import ReadingPlan, SharedReading, StoppedError
from aos_gcs.surveys.tiles import RasterTile, grouped
from aos_gcs.workers.arena import Arena, pack, unpack

GROUPS_PER_PROCESS = 1
"""Number of groups of tiles: more would balance the work, but an image is read once for every group that sees it."""

REPORT_INTERVAL_S = 0.5
"""Time between two reports of what is done."""


class _Memory:
    """Shared memory that a process receives when it is started."""

    def __init__(self, arena: Arena) -> None:
        self.arena = arena

    def __reduce__(self) -> tuple[Any, ...]:
        return _received, (reduction.DupFd(self.arena.fd),)


def _received(descriptor: Any) -> _Memory:
    return _Memory(Arena(descriptor.detach()))


@dataclass(slots=True)
class _Shared:
    """Data that the processes share."""

    done: Any
    """Number of images that are done, a shared integer."""
    is_stopped: Any
    """Event: results are not wanted any more."""
    condition: Any
    """Condition by which they tell each other how far they are."""
    request: _Memory
    """Arrays of what is to be done."""
    images: _Memory
    """Images that they read for each other."""


_shared: list[_Shared] = []
"""Shared data of this process, if it is one of the workers."""


class Processes:
    """Processes that integrate tiles; made by :func:`open_processes`."""

    def __init__(self, pool: ProcessPoolExecutor, shared: _Shared, count: int) -> None:
        self._pool, self._shared, self._count = pool, shared, count

    def groups(self, work: Work, tiles: Sequence[RasterTile]) -> list[list[RasterTile]]:
        """Return the groups of tiles that the processes compute one at a time."""
        return grouped(tiles, work.cell_bytes, work.max_bytes, GROUPS_PER_PROCESS * self._count)

    def integrate(
        self, work: Work, groups: Sequence[Sequence[RasterTile]], advance: Advance
    ) -> Iterator[list[TileResult]]:
        """Integrate groups of tiles; they come in the order in which they are done.

        Args:
            work: settings that all tiles share.
            groups: see :meth:`groups`.
            advance: called with the number of further images that are done, one for each group that sees it.

        Raises:
            AosError: as :func:`~aos_gcs.surveys.integration.integrate_tiles`; also if a process is lost.
        """
        # Only processes that work at the same time can read for each other.
        plan = ReadingPlan.of(work, groups) if len(groups) <= self._count else None
        request = pack((work, groups, plan), self._shared.request.arena)
        pending: set[Future[list[TileResult]]] = {
            self._pool.submit(_integrate, request, number) for number in range(len(groups))
        }
        reported = 0
        try:
            while pending:
                done, pending = wait(pending, REPORT_INTERVAL_S, FIRST_COMPLETED)
                reported, before = int(self._shared.done.value), reported
                advance(reported - before)
                for future in done:
                    yield future.result()
        except BrokenProcessPool as error:
            raise LinkError(
                "A process was lost while it integrated: use fewer --jobs or a smaller --max-memory, so that all of "
                "them fit into the memory."
            ) from error


@contextmanager
def open_processes(count: int, modules: Sequence[str] = ()) -> Iterator[Processes]:
    """Start processes for one integration; they import what they need while the caller reads what they are to do.

    Args:
        count: number of processes.
        modules: modules that they import besides.
    """
    # Forked processes would lack the threads that OpenCV and BLAS count on.
    context = get_context("spawn")
    request, images = Arena.create(), Arena.create()
    shared = _Shared(context.Value("L", 0), context.Event(), context.Condition(), _Memory(request), _Memory(images))
    try:
        with ProcessPoolExecutor(count, context, _begin, (shared, tuple(modules))) as pool:
            try:
                # Each call starts one, as long as none is idle.
                for _ in range(count):
                    pool.submit(_begun)
                yield Processes(pool, shared, count)
            finally:
                shared.is_stopped.set()
                pool.shutdown(cancel_futures=True)
    finally:
        request.close()
        images.close()


def _begin(shared: _Shared, modules: Sequence[str]) -> None:
    # Ctrl+C reaches all processes of a terminal; the first one stops the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    use_one_thread()
    for name in modules:
        importlib.import_module(name)
    _shared.append(shared)


def _begun() -> None:
    """Do nothing: the process has begun."""


def _integrate(request: bytes, number: int) -> list[TileResult]:
    """Integrate the group of tiles of a number."""
    shared = _shared[-1]
    work, groups, plan = unpack(request, shared.request.arena)
    tiles: Sequence[RasterTile] = groups[number]

    def advance(units: int) -> None:
        if shared.is_stopped.is_set():
            raise StoppedError
        with shared.done.get_lock():
            shared.done.value += units

    if plan is None:
        return integrate_tiles(work, tiles, advance)
    reading = SharedReading(
        plan,
        number,
        work,
        tiles[0].cell_m,
        memory=shared.images.arena.first(plan.memory_bytes),
        condition=shared.condition,
        is_stopped=shared.is_stopped.is_set,
    )
    return integrate_tiles(work, tiles, advance, reading)
