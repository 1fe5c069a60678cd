"""The pulse of a station whose worker spins, dies or takes all memory: measured in real time."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from aos_gcs.errors import WorkerError
from aos_gcs.workers.process import WorkerSettings, open_worker
from tests.fakes import work
from tests.fakes.pulse import beating

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("misbehave", [work.spin, work.end_oneself, work.take_memory])
async def test_the_heartbeat_goes_on(misbehave: Callable[[], object]) -> None:
    async with open_worker(WorkerSettings("Image analysis", 2 * 2**30, 15.0, ("numpy", "scipy", "cv2"))) as worker:
        await worker.ready()
        async with beating():
            for _ in range(2):
                with pytest.raises(WorkerError):
                    await worker.run(misbehave)
                assert await worker.run(work.process_id)
