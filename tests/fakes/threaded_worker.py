"""A worker of the service without a process, which takes half a second of processor to start."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from aos_gcs.ports.worker import ThreadWorker
from aos_gcs.workers.process import WorkerSettings


class ReadyWorker(ThreadWorker):
    """Computes in threads of this process."""

    async def ready(self) -> None:
        """Return at once."""


@asynccontextmanager
async def open_threaded_worker(_settings: WorkerSettings) -> AsyncIterator[ReadyWorker]:
    """Stand in for ``aos_gcs.workers.process.open_worker``."""
    yield ReadyWorker()
