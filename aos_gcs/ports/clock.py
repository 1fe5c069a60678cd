"""The clock that a mission flies by."""

from __future__ import annotations

import asyncio
from typing import Protocol


class Clock(Protocol):
    """The only source of time. Its seconds may pass faster than real ones when the vehicles are simulated."""

    @property
    def speed(self) -> float:
        """Clock seconds per real second; links and computers take real ones, however fast the clock."""
        ...

    def now_s(self) -> float:
        """Return monotonic seconds."""
        ...

    def utc_s(self) -> float:
        """Return seconds since the Unix epoch, advancing with ``now_s``."""
        ...

    async def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` clock seconds."""
        ...

    def timeout_at(self, deadline_s: float) -> asyncio.Timeout:
        """Return a context manager that raises ``TimeoutError`` when the clock passes ``deadline_s``."""
        ...
