"""The pulse of a station, without the time for which the machine gave its event loop no processor."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from aos_gcs.mission.health import STALL_S, LoopMonitor

HEARTBEAT_S = 1.0
MAX_GAP_S = 1.2
_LOOK_S = 0.1
_WAITED = Path("/proc/thread-self/schedstat")


def waited_s() -> float:
    """Return the time for which this thread was ready to run, but other programs had the processors."""
    try:
        return int(_WAITED.read_text(encoding="ascii").split()[1]) / 1e9
    except FileNotFoundError:
        pytest.skip("this system does not tell how long a thread waits for a processor")


class Pulse:
    """Heartbeats as the driver sends them, ten looks per second, and when the loop stood still.

    What the machine does meanwhile for others, such as for other tests, is measured and left out: only what holds the
    station's own loop counts.
    """

    def __init__(self) -> None:
        self._monitor = LoopMonitor()
        self._beats_s: list[float] = []
        self._looked_at_s = self._own_s()
        self.longest_stall_s = 0.0

    @staticmethod
    def _own_s() -> float:
        return asyncio.get_running_loop().time() - waited_s()

    async def run(self) -> None:
        """Beat until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._monitor.run(lambda _: None))
            group.create_task(self._beat())

    async def _beat(self) -> None:
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while True:
            own_s = self._own_s()
            self.longest_stall_s = max(self.longest_stall_s, own_s - self._looked_at_s - _LOOK_S)
            self._looked_at_s = own_s
            if loop.time() >= due_s and self._monitor.is_healthy():
                self._beats_s.append(own_s)
                due_s += HEARTBEAT_S
            await asyncio.sleep(_LOOK_S)

    def check(self) -> None:
        """Fail if heartbeats were missing, or the loop stood still by what the station does itself."""
        gaps_s = [after - before for before, after in itertools.pairwise(self._beats_s)]
        assert len(gaps_s) >= 3
        assert max(gaps_s) <= MAX_GAP_S
        assert self.longest_stall_s < STALL_S


@asynccontextmanager
async def beating() -> AsyncIterator[Pulse]:
    """Beat beside the block, and for two seconds before and after it; check then."""
    pulse = Pulse()
    task = asyncio.create_task(pulse.run())
    await asyncio.sleep(2.0)
    yield pulse
    await asyncio.sleep(2.0)
    task.cancel()
    pulse.check()
