"""An event loop whose time passes only when nothing is left to do: whole missions in seconds, the same in every run."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

_RESOLUTION_S = 1e-6
"""Added to each wait, so that the timer waited for is due whatever the rounding."""


_MAX_ROUNDS = 20_000
"""Rounds of the loop without time passing, which no mission needs."""


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """Timers fire in their order, without waiting. No sockets, no threads: nobody would wait for them.

    What others hand over to a thread is computed at once.
    """

    def __init__(self) -> None:
        self._now_s = 0.0
        self._idle_rounds = 0
        super().__init__()
        self._selector.select = self._pass_time  # type: ignore[attr-defined]

    def time(self) -> float:
        """Return the virtual time, seconds since the loop was made."""
        return self._now_s

    def run_in_executor(  # type: ignore[override]
        self, executor: Any, func: Callable[..., T], *args: Any
    ) -> asyncio.Future[T]:
        """Compute at once, and return the result as a future."""
        del executor
        future = self.create_future()
        try:
            future.set_result(func(*args))
        except Exception as error:
            future.set_exception(error)
        return future

    def set_default_executor(self, executor: Any) -> None:
        """Do without it: nothing is handed over to it, and at the end a thread would shut it down."""

    def _pass_time(self, timeout_s: float | None) -> list[Any]:
        if timeout_s is None:
            raise RuntimeError("deadlock: all tasks wait, and no timer is set")
        if timeout_s > 0.0:
            self._now_s += timeout_s + _RESOLUTION_S
            self._idle_rounds = 0
        self._idle_rounds += 1
        if self._idle_rounds > _MAX_ROUNDS:
            self._idle_rounds = 0  # as many again to end all tasks
            raise RuntimeError("endless loop: a task never waits")
        return []


class InlineWorker:
    """Worker (``aos_gcs.ports.Worker``) that computes at once: no virtual time passes meanwhile."""

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """See ``aos_gcs.ports.Worker``."""
        return function(*args, **kwargs)


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine in virtual time."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(main)
