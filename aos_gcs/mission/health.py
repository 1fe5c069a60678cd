"""Health of the event loop: whether the coordinator is alive, how late it runs, and when the station stood still."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable

import numpy as np

_WINDOW = 3000
"""Number of samples kept: one minute."""
_HEALTHY_WITHIN_S = 1.0
STALL_S = 1.0
"""Lag from which the station counts as stalled: a heartbeat is late by then."""
_STALL_REPEAT_S = 10.0
"""Real seconds within which only a longer stall is reported again."""
_CATCH_UP_S = 1.0
"""Time after a stall within which the links are read up to the present."""

_PUNCTUALITY_S = 10.0
"""Clock seconds of which the punctuality is judged."""
_POOR_SHARE = 0.25


class LoopMonitor:
    """Measures the lag of the running loop, in real milliseconds.

    Our MAVLink heartbeat is sent only while ``is_healthy``: when the loop or the mission stops, or a phase's handler
    hangs, so does the heartbeat, and the vehicles' link-loss failsafe acts.
    """

    def __init__(self, period_s: float = 0.02) -> None:
        self._period_s = period_s
        self._loop = asyncio.get_running_loop()
        self._lags_ms: deque[float] = deque(maxlen=_WINDOW)
        self._since_step_ms: list[float] = []
        self._ticked_at_s = self._loop.time()
        self._reported_at_s = -_STALL_REPEAT_S
        self._reported_stall_s = 0.0
        self._works: Callable[[], bool] = lambda: True
        self.longest_stall_s = 0.0
        """Duration of the longest stall so far; 0 if there was none."""

    async def run(self, on_stall: Callable[[float], None]) -> None:
        """Sample until cancelled.

        Args:
            on_stall: called with the seconds for which the loop stood still, if those are :data:`STALL_S` or more.
        """
        while True:
            due_s = self._loop.time() + self._period_s
            await asyncio.sleep(self._period_s)
            self._ticked_at_s = self._loop.time()
            lag_ms = (self._ticked_at_s - due_s) * 1e3
            self._lags_ms.append(lag_ms)
            self._since_step_ms.append(lag_ms)
            if lag_ms >= 1e3 * STALL_S and self._is_news(lag_ms / 1e3):
                on_stall(lag_ms / 1e3)

    def _is_news(self, stall_s: float) -> bool:
        self.longest_stall_s = max(self.longest_stall_s, stall_s)
        is_recent = self._ticked_at_s - self._reported_at_s < _STALL_REPEAT_S
        if is_recent and stall_s <= self._reported_stall_s:
            return False
        self._reported_at_s, self._reported_stall_s = self._ticked_at_s, stall_s
        return True

    def depend_on(self, works: Callable[[], bool]) -> None:
        """Be healthy only while ``works`` returns true, too, such as whether the mission goes on."""
        self._works = works

    def is_healthy(self) -> bool:
        """Return whether the loop has run within the last second, and the mission goes on."""
        return self._loop.time() - self._ticked_at_s < _HEALTHY_WITHIN_S and self._works()

    def take_step_lag_p99_ms(self) -> float:
        """Return the 99th percentile of the lag since the last call."""
        samples, self._since_step_ms = self._since_step_ms, []
        return float(np.percentile(samples, 99)) if samples else 0.0

    def lag_p99_ms(self) -> float:
        """Return the 99th percentile of the last minute's lag."""
        return float(np.percentile(self._lags_ms, 99)) if self._lags_ms else 0.0


class CatchingUp:
    """Tells a vehicle's silence from the station's: after a stall, what vehicles sent meanwhile is not read yet."""

    def __init__(self) -> None:
        self._looked_at_s: float | None = None
        self._until_s = -math.inf

    def look(self, now_s: float) -> bool:
        """Return whether the silence of vehicles says nothing yet; call it ten times per clock second.

        A station that stalls again and again still sees lost links: it catches up for a fifth of the time at most.
        """
        stalled = self._looked_at_s is not None and now_s - self._looked_at_s >= STALL_S
        self._looked_at_s = now_s
        if stalled and now_s >= self._until_s + 4 * _CATCH_UP_S:
            self._until_s = now_s + _CATCH_UP_S
        return now_s < self._until_s


class Punctuality:
    """Tells whether this station has been late for much of the last seconds, without standing still for long at once.

    Args:
        period_s: clock seconds between two looks, if they are on time.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._looks: deque[tuple[float, float]] = deque()
        """Time of each look of the last seconds, and by how much it was late."""
        self._looked_at_s: float | None = None

    @property
    def is_poor(self) -> bool:
        """Whether the looks were late by a quarter of the time or more."""
        return sum(late_s for _, late_s in self._looks) >= _POOR_SHARE * _PUNCTUALITY_S

    def look(self, now_s: float) -> None:
        """Note that it is the time of a look."""
        late_s = 0.0 if self._looked_at_s is None else max(0.0, now_s - self._looked_at_s - self._period_s)
        self._looked_at_s = now_s
        self._looks.append((now_s, late_s))
        while self._looks[0][0] < now_s - _PUNCTUALITY_S:
            self._looks.popleft()
