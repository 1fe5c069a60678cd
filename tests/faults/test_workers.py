"""The pulse of a station whose worker spins, dies or takes all memory: measured in real time."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable

import pytest

from aos_gcs.errors import WorkerError
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.workers.process import WorkerSettings, open_worker
from tests.fakes import work

pytestmark = pytest.mark.slow

HEARTBEAT_S = 1.0
MAX_GAP_S = 1.2


async def beat(monitor: LoopMonitor, beats_s: list[float]) -> None:
    """Send heartbeats as the driver does, ten looks per second."""
    loop = asyncio.get_running_loop()
    due_s = loop.time()
    while True:
        if loop.time() >= due_s and monitor.is_healthy():
            beats_s.append(loop.time())
            due_s += HEARTBEAT_S
        await asyncio.sleep(0.1)


@pytest.mark.parametrize("misbehave", [work.spin, work.end_oneself, work.take_memory])
async def test_the_heartbeat_goes_on(misbehave: Callable[[], object]) -> None:
    monitor, beats_s = LoopMonitor(), list[float]()
    async with open_worker(WorkerSettings("Image analysis", 2 * 2**30, 15.0, ("numpy", "scipy", "cv2"))) as worker:
        await worker.ready()
        tasks = [asyncio.create_task(one) for one in (monitor.run(lambda _: None), beat(monitor, beats_s))]
        await asyncio.sleep(2.0)
        for _ in range(2):
            with pytest.raises(WorkerError):
                await worker.run(misbehave)
            assert await worker.run(work.process_id)
        await asyncio.sleep(2.0)
        for task in tasks:
            task.cancel()
    gaps_s = [after - before for before, after in itertools.pairwise(beats_s)]
    assert len(gaps_s) >= 3
    assert max(gaps_s) <= MAX_GAP_S
    assert monitor.longest_stall_s == 0.0
