"""Ownership of the driver's background tasks."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from types import TracebackType


class BackgroundTasks:
    """Owns tasks for as long as it is entered, then cancels and awaits them.

    Unlike ``asyncio.TaskGroup``, it lets the errors of the body through as they are, so that a driver's user can catch
    them by type. A task that fails is reported at once to ``on_failure`` and its error raised at the end.
    """

    def __init__(self, on_failure: Callable[[BaseException], None]) -> None:
        self._on_failure = on_failure
        self._tasks: set[asyncio.Task[None]] = set()

    async def __aenter__(self) -> BackgroundTasks:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for task in self._tasks:
            task.cancel()
        if self._tasks:
            await asyncio.wait(self._tasks)
        failures = [task.exception() for task in self._tasks if not task.cancelled()]
        for failure in failures:
            if failure is not None and error is None:
                raise failure

    def start(self, work: Coroutine[object, object, None]) -> None:
        """Run ``work`` until it ends or the owner exits."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._on_done)

    def _on_done(self, task: asyncio.Task[None]) -> None:
        failure = None if task.cancelled() else task.exception()
        if failure is not None:
            self._on_failure(failure)
