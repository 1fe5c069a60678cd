"""Path from exposures to images that can be fetched: renderer, worker threads, and image server or folder."""

from __future__ import annotations

import asyncio
import math
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack
from types import TracebackType
from typing import Self

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_sim.camera.component import Exposure
from aos_sim.camera.folder import ImageFolder
from aos_sim.camera.image import ImageSource, encode_tiff
from aos_sim.camera.server import ImageServer
from aos_sim.errors.cameras import ErringCameras
from aos_sim.errors.exposure import Motion
from aos_sim.errors.model import ErrorModel

_THREADS = 2
_NICENESS = 10
"""Priority of rendering, below that of the service's image workers: in the field, cameras are other machines."""


def check_camera_options(image_size_px: int, fov_rad: float, http_port: int) -> None:
    """Check the options of cameras and their image server.

    Raises:
        ConfigurationError: a value is out of its range.
    """
    if not 16 <= image_size_px <= 4096:
        raise ConfigurationError(f"--image-size must lie within 16 and 4096, got {image_size_px}.")
    if not 0.0 < fov_rad < math.pi:
        raise ConfigurationError(f"--fov must lie within 0 and 180 degrees, got {math.degrees(fov_rad):g}.")
    if not 0 <= http_port <= 65535:
        raise ConfigurationError(f"--http-port must lie within 0 and 65535, got {http_port}.")


class Darkroom:
    """Develops the exposures of all cameras, for as long as it is entered.

    Policy: two images at a time, the others wait; each camera limits how many of its own do.

    Args:
        source: source of the cameras' images.
        camera: the model of all cameras.
        errors: errors of gimbals, shutters, lenses and sensors.
        seed: seed of the errors.
        publisher: server or folder of the images.

    Raises:
        AosError: on entering, if the publisher cannot.
    """

    def __init__(
        self,
        source: ImageSource,
        camera: CameraModel,
        errors: ErrorModel,
        seed: int,
        publisher: ImageServer | ImageFolder,
    ) -> None:
        self.camera = camera
        self._source = source
        self._seed = seed
        self._cameras = ErringCameras(errors, camera, seed)
        self._publisher = publisher
        self._pool = ThreadPoolExecutor(_THREADS, thread_name_prefix="render", initializer=_step_back)
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

    async def develop(self, exposure: Exposure, motion: Motion) -> str:
        """Return the URL, or the path, of the image that a camera takes while its vehicle moves like this."""
        loop = asyncio.get_running_loop()
        data = await loop.run_in_executor(self._pool, self._image, exposure, motion)
        return self._publisher.publish(exposure.system_id, exposure.index, data)

    def _image(self, exposure: Exposure, motion: Motion) -> bytes:
        frame = self._cameras.expose(
            self._source.view,
            motion,
            np.random.default_rng((self._seed, exposure.system_id, exposure.index)),
            camera_id=exposure.system_id,
            index=exposure.index,
            at_s=exposure.at.s,
        )
        return encode_tiff(frame)


def _step_back() -> None:
    """Let the service on the same machine go before this thread."""
    if sys.platform == "linux":  # Elsewhere a priority is that of the whole process.
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
