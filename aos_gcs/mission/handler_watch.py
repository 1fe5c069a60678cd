"""Signs of life of the present phase's handler: one that hangs must not stay unnoticed behind a loop that runs.

A handler, and whatever runs in its task, shows by :func:`sign_of_life` that it goes on, and for how long it may be busy
until it does so again. In other tasks the function has no effect.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine
from contextvars import Context, ContextVar, copy_context
from typing import Any, TypeVar

T = TypeVar("T")

SILENCE_S = 5.0
"""Time within which a handler shows a sign of life where it has not announced more, real seconds."""
WORK_S = 30.0
"""Time that imaging may take for one step: far more than it needs, even on a busy machine."""
_RECOVERY_S = 2.0
"""Time for another handler to begin in place of one that hangs, before the heartbeat stops."""
_PERIOD_S = 0.5

_WATCH: ContextVar[HandlerWatch | None] = ContextVar("handler_watch", default=None)


def sign_of_life(busy_s: float = 0.0) -> None:
    """Show that the handler in whose task this is called goes on.

    Args:
        busy_s: seconds for which it may give no other sign, such as until a deadline.
    """
    if (watch := _WATCH.get()) is not None:
        watch.expect(busy_s + SILENCE_S)


def unwatched() -> Context:
    """Return a context for a task beside the handler: what goes on there says nothing about the handler's own work."""
    context = copy_context()
    context.run(_WATCH.set, None)
    return context


class HandlerWatch:
    """Measures for how long a running handler has been overdue with a sign of life."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._due_s = math.inf
        self._is_reported = False

    def start(self, handler: Coroutine[Any, Any, T]) -> asyncio.Task[T]:
        """Run a handler in a task that is watched until :meth:`rest`."""
        self.expect(SILENCE_S)
        self._is_reported = False
        context = copy_context()
        context.run(_WATCH.set, self)
        return asyncio.create_task(handler, context=context)

    def rest(self) -> None:
        """Watch nothing: no handler runs."""
        self._due_s = math.inf

    def expect(self, within_s: float) -> None:
        """Expect the next sign of life within some real seconds."""
        self._due_s = self._loop.time() + within_s

    def is_alive(self) -> bool:
        """Return whether the handler shows signs of life, or was replaced in time."""
        return self._loop.time() <= self._due_s + _RECOVERY_S

    async def run(self, on_hung: Callable[[], None]) -> None:
        """Watch until cancelled; ``on_hung`` is called once for each handler that is overdue."""
        while True:
            await asyncio.sleep(_PERIOD_S)
            if self._loop.time() > self._due_s and not self._is_reported:
                self._is_reported = True
                on_hung()
