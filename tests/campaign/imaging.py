"""The analysis of images of a campaign's station, which may hang or die."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from aos_gcs.errors import WorkerError
from aos_gcs.ports.worker import ThreadWorker

P = ParamSpec("P")
T = TypeVar("T")

_REPLACED_S = 1.0
"""Time until a process that has died is replaced."""


class FaultyWorker(ThreadWorker):
    """Computes in this process, unless a fault keeps it from it."""

    def __init__(self) -> None:
        self.hangs_until_s = -math.inf
        """Time on the event loop before which nothing is answered."""
        self.dies_until_s = -math.inf
        """Time before which every call ends the process."""

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """See :class:`aos_gcs.ports.worker.Worker`."""
        now_s = asyncio.get_running_loop().time()
        if now_s < self.dies_until_s:
            await asyncio.sleep(_REPLACED_S)
            raise WorkerError("the image analysis was ended by a fault of the campaign")
        await asyncio.sleep(max(0.0, self.hangs_until_s - now_s))
        return await super().run(function, *args, **kwargs)
