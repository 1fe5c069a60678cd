"""Fetching images from a web server on the loopback interface."""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import AsyncIterator
from dataclasses import dataclass

import aiohttp
import cv2
import numpy as np
import pytest
from aiohttp import web

from aos_drivers.frames.errors import PendingImageError, TornFrameError
from aos_drivers.frames.files.fetching import ImageFetcher, ImageLimits
from aos_gcs.clock import LoopClock
from aos_gcs.errors import CaptureError
from tests.timing import scaled_s

HOST = "127.0.0.1"
PNG = bytes(cv2.imencode(".png", np.full((6, 8), 77, np.uint8))[1])


@dataclass
class Bench:
    fetcher: ImageFetcher
    clock: LoopClock
    base: str

    async def fetch(self, url: str, host: str = HOST) -> object:
        return await self.fetcher.fetch(url, host, self.clock.now_s() + scaled_s(30.0))


async def serve_image(_request: web.Request) -> web.Response:
    return web.Response(body=PNG)


async def serve_redirect(_request: web.Request) -> web.Response:
    raise web.HTTPFound("/good.png")


async def serve_large(_request: web.Request) -> web.Response:
    return web.Response(body=bytes(3 * 2**20))


async def serve_never(_request: web.Request) -> web.Response:
    await asyncio.sleep(30)
    return web.Response()


async def serve_cut(request: web.Request) -> web.StreamResponse:
    response = web.StreamResponse(headers={"Content-Length": str(len(PNG))})
    await response.prepare(request)
    await response.write(PNG[:20])
    assert request.transport is not None
    request.transport.close()
    return response


async def serve_bomb(_request: web.Request) -> web.Response:
    body = bytes(cv2.imencode(".png", np.zeros((101, 100), np.uint8))[1])
    return web.Response(body=body)


async def serve_packed(_request: web.Request) -> web.Response:
    return web.Response(body=gzip.compress(PNG), headers={"Content-Encoding": "gzip"})


async def serve_dated(_request: web.Request) -> web.Response:
    dates = {"Date": "Fri, 20 Nov 2026 10:00:09 GMT", "Last-Modified": "Fri, 20 Nov 2026 10:00:02 GMT"}
    return web.Response(body=PNG, headers=dates)


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    app = web.Application()
    app.router.add_get("/good.png", serve_image)
    app.router.add_get("/redirect.png", serve_redirect)
    app.router.add_get("/large.png", serve_large)
    app.router.add_get("/never.png", serve_never)
    app.router.add_get("/cut.png", serve_cut)
    app.router.add_get("/bomb.png", serve_bomb)
    app.router.add_get("/packed.png", serve_packed)
    app.router.add_get("/dated.png", serve_dated)
    runner = web.AppRunner(app, shutdown_timeout=0.1)
    await runner.setup()
    site = web.TCPSite(runner, HOST, 0)
    await site.start()
    port = runner.addresses[0][1]
    async with aiohttp.ClientSession() as session:
        clock = LoopClock()
        yield Bench(
            ImageFetcher(session, clock, ImageLimits(2**20, 10_000), ("files.example",)), clock, f"http://{HOST}:{port}"
        )
    await runner.cleanup()


async def test_an_image_of_the_vehicles_own_host_is_fetched(bench: Bench) -> None:
    image, bands = await bench.fetch(f"{bench.base}/good.png")  # type: ignore[misc]
    assert bands == ("grey",)
    assert image.shape == (6, 8, 1)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("/missing.png", "status 404"),
        ("/redirect.png", "status 302"),
        ("/large.png", "larger than 1 MiB"),
        ("/cut.png", "cannot be fetched"),
        ("/bomb.png", "megapixels.*max_image_megapixels"),
        ("/packed.png", "compressed"),
    ],
)
async def test_bad_answers_are_named(bench: Bench, path: str, words: str) -> None:
    with pytest.raises(CaptureError, match=words):
        await bench.fetch(bench.base + path)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("", "no file server"),
        ("file:///etc/passwd", "not http"),
        ("ftp://127.0.0.1/a", "not http"),
        ("http://192.168.0.9/a.png", "own host"),
        ("http://printer/a.png", "own host"),
        (f"http://{HOST}@printer/a.png", "own host"),
        ("http://[::ffff:127.0.0.1]/a.png", "own host"),
        ("http://2130706433/a.png", "own host"),
        ("http://[::1", "cannot be understood"),
        ("http:///a.png", "not http|understood"),
    ],
)
async def test_hostile_addresses_are_never_called(bench: Bench, url: str, words: str) -> None:
    with pytest.raises(CaptureError, match=words):
        await bench.fetch(url)


@pytest.mark.parametrize(
    "address",
    ["/good", "/good.png?delete=all", "/good.png#x", "/admin/good.png/", "/", "/good.png;/x", "/good.png/..%2f"],
)
async def test_of_the_station_itself_a_vehicle_behind_a_router_names_files_of_images_only(
    bench: Bench, address: str
) -> None:
    with pytest.raises(CaptureError, match=r"on this machine .* image_hosts"):
        await bench.fetch(bench.base + address)


@pytest.mark.parametrize(
    "address", [f"http://{HOST}/a.png", f"http://{HOST}:631/a.png", f"http://me@{HOST}:8000/a.png"]
)
async def test_services_of_the_system_are_never_asked(bench: Bench, address: str) -> None:
    with pytest.raises(CaptureError, match="on this machine"):
        await bench.fetch(address)


async def test_localhost_is_a_loopback_vehicle_only(bench: Bench) -> None:
    await bench.fetch(bench.base.replace(HOST, "localhost") + "/good.png")
    with pytest.raises(CaptureError, match="own host"):
        await bench.fetch("http://localhost/good.png", host="10.0.0.5")


async def test_the_deadline_ends_a_slow_download(bench: Bench) -> None:
    with pytest.raises(CaptureError, match="in time"):
        await bench.fetcher.fetch(f"{bench.base}/never.png", HOST, bench.clock.now_s() + 0.1)


async def test_the_kind_of_failure_says_whether_another_look_is_worth_it(bench: Bench) -> None:
    with pytest.raises(PendingImageError):
        await bench.fetch(f"{bench.base}/missing.png")
    with pytest.raises(TornFrameError):
        await bench.fetch(f"{bench.base}/cut.png")


async def test_the_age_of_a_file_is_that_by_the_servers_clock(bench: Bench) -> None:
    deadline_s = bench.clock.now_s() + scaled_s(30.0)
    assert (await bench.fetcher.download(f"{bench.base}/dated.png", HOST, deadline_s)).age_s == 7.0
    assert (await bench.fetcher.download(f"{bench.base}/good.png", HOST, deadline_s)).age_s is None
