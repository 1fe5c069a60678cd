"""The clock of the service, and the date."""

from __future__ import annotations

import asyncio
import time
from datetime import UTC, datetime


class LoopClock:
    """Time of the running event loop, optionally faster than real time.

    Args:
        speed: clock seconds per loop second; above 1 when simulated vehicles fly faster than real ones.
    """

    def __init__(self, speed: float = 1.0) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be positive, got {speed}")
        self._speed = speed
        self._loop = asyncio.get_running_loop()
        self._start_loop_s = self._loop.time()
        self._start_utc_s = time.time()

    @property
    def speed(self) -> float:
        """Clock seconds per loop second."""
        return self._speed

    @property
    def start_utc_s(self) -> float:
        """Time at which the clock was made, in seconds since the Unix epoch."""
        return self._start_utc_s

    def now_s(self) -> float:
        """Return monotonic clock seconds since the clock was made."""
        return (self._loop.time() - self._start_loop_s) * self._speed

    def utc_s(self) -> float:
        """Return seconds since the Unix epoch; runs ahead of the real time when ``speed`` is above 1."""
        return self._start_utc_s + self.now_s()

    async def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` clock seconds."""
        await asyncio.sleep(duration_s / self._speed)

    def timeout_at(self, deadline_s: float) -> asyncio.Timeout:
        """Return a context manager that raises ``TimeoutError`` when the clock passes ``deadline_s``."""
        return asyncio.timeout_at(self._start_loop_s + deadline_s / self._speed)


def machine_utc_s() -> float:
    """Return seconds since the Unix epoch by this machine's own clock, which jumps when it is set."""
    return time.time()


def today_utc() -> str:
    """Return the day in UTC, YYYY-MM-DD."""
    return datetime.fromtimestamp(time.time(), UTC).date().isoformat()
