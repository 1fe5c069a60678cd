"""Waiting until a condition on a vehicle holds."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from aos_gcs.ports import Clock

CLOCK_RESOLUTION_S = 1e-3
"""Time by which a wait may end early, by the rounding between clock and loop."""


class Changes:
    """Wakes all waiters, in the order of their arrival, whenever something about a vehicle may have changed."""

    __slots__ = ("_clock", "_waiters")

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiters: dict[asyncio.Future[None], None] = {}

    def announce(self) -> None:
        """Make every waiter check its condition again."""
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(None)

    async def wait_for(self, condition: Callable[[], bool], until_s: float) -> bool:
        """Return whether ``condition`` held before clock time ``until_s``; its exceptions are passed on."""
        try:
            async with self._clock.timeout_at(until_s):
                while not condition():
                    await self._next()
        except TimeoutError:
            return condition()
        return True

    async def _next(self) -> None:
        waiter = asyncio.get_running_loop().create_future()
        self._waiters[waiter] = None
        try:
            await waiter
        finally:
            self._waiters.pop(waiter)
