"""Health of the event loop: whether the coordinator is alive, and how late it runs."""

from __future__ import annotations

import asyncio
from collections import deque

import numpy as np

_WINDOW = 3000
"""Number of samples kept: one minute."""
_HEALTHY_WITHIN_S = 1.0


class LoopMonitor:
    """Measures the lag of the running loop, in real milliseconds.

    Our MAVLink heartbeat is sent only while ``is_healthy``: when the loop or the mission stops, so does the heartbeat,
    and the vehicles' link-loss failsafe acts.
    """

    def __init__(self, period_s: float = 0.02) -> None:
        self._period_s = period_s
        self._loop = asyncio.get_running_loop()
        self._lags_ms: deque[float] = deque(maxlen=_WINDOW)
        self._since_step_ms: list[float] = []
        self._ticked_at_s = self._loop.time()

    async def run(self) -> None:
        """Sample until cancelled."""
        while True:
            due_s = self._loop.time() + self._period_s
            await asyncio.sleep(self._period_s)
            self._ticked_at_s = self._loop.time()
            lag_ms = (self._ticked_at_s - due_s) * 1e3
            self._lags_ms.append(lag_ms)
            self._since_step_ms.append(lag_ms)

    def is_healthy(self) -> bool:
        """Return whether the mission's task group has run within the last second."""
        return self._loop.time() - self._ticked_at_s < _HEALTHY_WITHIN_S

    def take_step_lag_p99_ms(self) -> float:
        """Return the 99th percentile of the lag since the last call."""
        samples, self._since_step_ms = self._since_step_ms, []
        return float(np.percentile(samples, 99)) if samples else 0.0

    def lag_p99_ms(self) -> float:
        """Return the 99th percentile of the last minute's lag."""
        return float(np.percentile(self._lags_ms, 99)) if self._lags_ms else 0.0
