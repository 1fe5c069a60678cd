"""Patience with other parts: a time limit that tells their delay from that of this process itself."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

_TICKS: Final = 20
"""Number of looks within the limit: each counts as much, however late it comes."""
_LATE_SHARE: Final = 0.25
"""Share of the limit by which the looks are late when this process is short of processor time."""
_LONGEST: Final = 3.0
"""Factor by which the limit is stretched at most."""


@dataclass(slots=True)
class Wait:
    """One wait, as it was so far."""

    limit_s: float
    late_s: float = 0.0
    """Time by which the event loop was late meanwhile."""

    @property
    def is_own_fault(self) -> bool:
        """Whether this process was so late itself that the wait says nothing of what was waited for."""
        return self.late_s >= _LATE_SHARE * self.limit_s


@asynccontextmanager
async def patience(limit_s: float) -> AsyncIterator[Wait]:
    """Limit the time of the block, in real seconds; time in which the event loop stands still does not count.

    Raises:
        TimeoutError: the block took longer, or three times as long with the time in which the loop was late.
    """
    loop, wait, period_s = asyncio.get_running_loop(), Wait(limit_s), limit_s / _TICKS
    handle: asyncio.TimerHandle
    async with asyncio.timeout(None) as timeout:

        def look(ticks: int, due_s: float) -> None:
            nonlocal handle
            now_s = loop.time()
            wait.late_s += now_s - due_s
            if ticks >= _TICKS or now_s - started_s >= _LONGEST * limit_s:
                timeout.reschedule(now_s)
                return
            handle = loop.call_at(now_s + period_s, look, ticks + 1, now_s + period_s)

        started_s = loop.time()
        handle = loop.call_at(started_s + period_s, look, 1, started_s + period_s)
        try:
            yield wait
        finally:
            handle.cancel()
