"""A ground station whose event loop is blocked, beside vehicles that fly on in the same loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import Context, ContextVar, copy_context
from functools import partial
from typing import Any

_IS_STATION: ContextVar[bool] = ContextVar("is_station", default=False)


@contextmanager
def station() -> Iterator[None]:
    """Mark what is started within as part of the ground station."""
    token = _IS_STATION.set(True)
    try:
        yield
    finally:
        _IS_STATION.reset(token)


class StationLoop:
    """Holds back all callbacks of the station while it is frozen, and runs them at once afterwards.

    That is what a blocked loop does: tasks do not run, timers fire late, and all that was due is due together.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._call_soon, self._call_at = loop.call_soon, loop.call_at
        self._held: list[tuple[Callable[[], None], Context]] | None = None
        loop.call_soon = self._soon  # type: ignore[method-assign, assignment]
        loop.call_at = self._at  # type: ignore[method-assign, assignment]

    @property
    def is_frozen(self) -> bool:
        """Whether the station stands still."""
        return self._held is not None

    def freeze(self) -> None:
        """Stop the station."""
        self._held = []

    def thaw(self) -> None:
        """Let the station go on, with everything that it has missed."""
        held, self._held = self._held or [], None
        for run, context in held:
            self._call_soon(run, context=context)

    def _soon(self, callback: Callable[..., object], *args: object, context: Context | None = None) -> asyncio.Handle:
        return self._schedule(self._call_soon, partial(callback, *args), context)

    def _at(
        self, when_s: float, callback: Callable[..., object], *args: object, context: Context | None = None
    ) -> asyncio.Handle:
        return self._schedule(partial(self._call_at, when_s), partial(callback, *args), context)

    def _schedule(
        self, schedule: Callable[..., Any], callback: Callable[[], object], context: Context | None
    ) -> asyncio.Handle:
        context = copy_context() if context is None else context
        handle: asyncio.Handle

        def run() -> None:
            if handle.cancelled():
                return
            if self._held is not None and _IS_STATION.get():
                self._held.append((run, context))
            else:
                callback()

        handle = schedule(run, context=context)
        return handle
