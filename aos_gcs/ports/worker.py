"""Workers: where computations run that must not stop the flight."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import ParamSpec, Protocol, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Worker(Protocol):
    """Runs functions of the module level, one after the other, beside the flight loop."""

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the function's result, or raise what it raises; neither it nor its arguments may be changed by it.

        Cancelling the call does not stop the function: it ends by itself, or by the worker's time limit.

        Raises:
            WorkerError: the worker has died, run out of memory or taken too long; the next call finds a new one.
        """
        ...


class ThreadWorker:
    """Worker in threads of this process, for tests, tools and replays: nothing limits its memory or its time."""

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """See :class:`Worker`."""
        return await asyncio.to_thread(function, *args, **kwargs)
