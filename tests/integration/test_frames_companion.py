"""Frames whose files a companion computer serves over HTTP."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import aiohttp
import pytest
from aiohttp import web

from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.settings import CameraSettings, ImagePlace, SourceKind
from aos_gcs.clock import LoopClock
from tests.fakes.mavlink_fleet import Network
from tests.fakes.shutter_vehicle import LIMITS, ShutterVehicle, deadline_s, open_camera, picture
from tests.timing import scaled_s

FOV_RAD = 0.9


@asynccontextmanager
async def bench(vehicle: ShutterVehicle, settings: CameraSettings) -> AsyncIterator[Network]:
    async with (
        aiohttp.ClientSession() as session,
        open_camera(vehicle, settings, ImageFetcher(session, LoopClock(), LIMITS, ())) as network,
    ):
        yield network


@asynccontextmanager
async def companion(files: dict[str, bytes]) -> AsyncIterator[str]:
    """Serve files by name, and their listing; yields the address."""

    async def answer(request: web.Request) -> web.Response:
        name = request.match_info["name"]
        if not name:
            links = "".join(f'<a href="{entry}">{entry}</a>' for entry in files)
            return web.Response(text=links, content_type="text/html")
        if name not in files:
            raise web.HTTPNotFound
        response = web.Response(body=files[name])
        response.last_modified = time.time()
        return response

    app = web.Application()
    app.router.add_get("/{name:.*}", answer)
    runner = web.AppRunner(app, shutdown_timeout=0.1)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    try:
        yield f"http://127.0.0.1:{runner.addresses[0][1]}"
    finally:
        await runner.cleanup()


@pytest.mark.parametrize("path", ["/{index:05d}.png", "/"])
async def test_a_companion_serves_the_image_by_its_index_or_in_a_listing(path: str) -> None:
    files = {"00007.png": picture(7)}
    vehicle = ShutterVehicle(
        lambda shot: (
            asyncio.get_running_loop().call_later(0.3, files.__setitem__, f"{shot:05d}.png", picture(shot)) and None
        )
    )
    async with companion(files) as base:
        settings = CameraSettings(SourceKind.REPORTED, ImagePlace(url=base + path), fov_rad=FOV_RAD)
        async with bench(vehicle, settings) as network:
            capture = await network.vehicle().capture(deadline_s(network, scaled_s(20.0)))
    assert (capture.image_index, capture.image[0, 0, 0]) == (42, 42)
