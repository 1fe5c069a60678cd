"""Serves the images of all cameras over HTTP, on the loopback interface."""

from __future__ import annotations

from collections import OrderedDict
from types import TracebackType
from typing import Self

from aiohttp import web

from aos_gcs.errors import LinkError

HOST = "127.0.0.1"


class ImageServer:
    """``GET /<system id>/<image index>.tiff``, for as long as the server is entered.

    Policy: the newest ``kept`` images of each vehicle are held in memory, the oldest is dropped; a dropped or unknown
    one is answered with 404.

    Args:
        port: 0 for any free one.

    Raises:
        LinkError: on entering, if the port is taken.
    """

    def __init__(self, port: int = 0, kept: int = 8) -> None:
        self._port = port
        self._kept = kept
        self._images: dict[int, OrderedDict[int, bytes]] = {}
        application = web.Application()
        application.router.add_get(r"/{system_id:\d+}/{index:\d+}.tiff", self._get)
        self._runner = web.AppRunner(application, access_log=None)

    async def __aenter__(self) -> Self:
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, HOST, self._port).start()
        except OSError as error:
            await self._runner.cleanup()
            raise LinkError(
                f"The image server cannot listen on {HOST}:{self._port} ({error.strerror}); choose another --http-port."
            ) from error
        self._port = self._runner.addresses[0][1]
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self._runner.cleanup()

    def publish(self, system_id: int, index: int, data: bytes) -> str:
        """Keep an image and return the URL that serves it."""
        images = self._images.setdefault(system_id, OrderedDict())
        images[index] = data
        while len(images) > self._kept:
            images.popitem(last=False)
        return f"http://{HOST}:{self._port}/{system_id}/{index}.tiff"

    async def _get(self, request: web.Request) -> web.Response:
        system_id, index = int(request.match_info["system_id"]), int(request.match_info["index"])
        data = self._images.get(system_id, OrderedDict()).get(index)
        if data is None:
            raise web.HTTPNotFound(text=f"Vehicle {system_id} has no image {index} (any more).")
        return web.Response(body=data, content_type="image/tiff")
