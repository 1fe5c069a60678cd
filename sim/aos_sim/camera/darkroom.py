"""From exposures to images that can be fetched: renderer, worker threads, and image server or folder."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack
from types import TracebackType
from typing import Self

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.camera.component import Exposure
from aos_sim.camera.folder import ImageFolder
from aos_sim.camera.image import ImageSource, develop
from aos_sim.camera.server import ImageServer

_THREADS = 2


class Darkroom:
    """Develops the exposures of all cameras, for as long as it is entered.

    Policy: two images at a time, the others wait; each camera limits how many of its own do.

    Args:
        source: source of the cameras' images.
        camera: the model of all cameras.
        seed: seed of the sensors' noise.
        publisher: server or folder of the images.

    Raises:
        AosError: on entering, if the publisher cannot.
    """

    def __init__(
        self, source: ImageSource, camera: CameraModel, seed: int, publisher: ImageServer | ImageFolder
    ) -> None:
        self.camera = camera
        self._source = source
        self._seed = seed
        self._publisher = publisher
        self._pool = ThreadPoolExecutor(_THREADS, thread_name_prefix="render")
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            stack.callback(self._pool.shutdown, wait=True, cancel_futures=True)
            await stack.enter_async_context(self._publisher)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    async def develop(self, exposure: Exposure, pose: Pose) -> str:
        """Return the URL, or the path, of the image that the camera takes from ``pose`` in the world."""
        seed = (self._seed, exposure.system_id, exposure.index)
        loop = asyncio.get_running_loop()
        data = await loop.run_in_executor(self._pool, develop, self._source, pose, self.camera, seed)
        return self._publisher.publish(exposure.system_id, exposure.index, data)
