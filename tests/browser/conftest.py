"""Chromium, the dashboard's build and a served mission for the tests of the page."""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
from collections.abc import AsyncIterator, Callable, Generator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import NoReturn
from urllib.parse import urlsplit

import pluggy
import pytest
import pytest_asyncio
from fastapi import FastAPI
from playwright.async_api import (
    Browser,
    ConsoleMessage,
    Error,
    Page,
    Request,
    Response,
    ViewportSize,
    async_playwright,
    expect,
)

from aos_gcs.api.app import create_app
from aos_gcs.api.page import STATIC_FOLDER
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.runtime.recorded.operation import ReplayedOperation
from aos_gcs.runtime.recorded.viewer import Viewer
from tests.browser.pages import TIMEOUT_MS
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.program import unused_port
from tests.fakes.recording import record
from tests.fakes.viewed_step import record_viewed_step

expect.set_options(timeout=TIMEOUT_MS)

_CHROMIUM_NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""The same browser without its window comes first: it takes a quarter less of the processor."""
_CHROMIUM_ARGUMENTS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
AXE = Path(__file__).parents[2] / "web" / "node_modules" / "axe-core" / "axe.min.js"
WITHOUT_WEBGL = """const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.startsWith("webgl") ? null : get.call(this, kind, ...more);
};"""
VIEWPORT_PX: ViewportSize = {"width": 1280, "height": 800}
_MISSION_SPEED = 8.0
OPERATOR_CODE = "correct-horse"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "tests/browser" in item.path.as_posix():
            item.add_marker(pytest.mark.browser)


def unavailable(reason: str) -> NoReturn:
    """Skip on a user's machine; on CI a browser test that cannot run is a failure."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{reason} (required with CI=true)")
    pytest.skip(reason)


@pytest.fixture(scope="session")
def chromium_path() -> str:
    """The browser named by AOS_GCS_CHROMIUM, else the first one installed."""
    candidates = (os.environ.get("AOS_GCS_CHROMIUM"), *map(shutil.which, _CHROMIUM_NAMES))
    path = next((candidate for candidate in candidates if candidate), None)
    if path is None or shutil.which(path) is None:
        unavailable("no Chromium found: install it, or name it in AOS_GCS_CHROMIUM")
    return path


@pytest.fixture(scope="session")
def dashboard_build() -> None:
    """The dashboard must have been built, as make does before the tests."""
    if not (STATIC_FOLDER / "index.html").is_file():
        unavailable("the dashboard is not built: run npm ci and npm run build in web/")


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def browser(chromium_path: str) -> AsyncIterator[Browser]:
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=chromium_path, args=_CHROMIUM_ARGUMENTS)
        yield browser
        await browser.close()


@dataclass
class PageRecord:
    """What a page has complained about and asked for."""

    errors: list[str] = field(default_factory=list)
    foreign_requests: list[str] = field(default_factory=list)
    failed_requests: list[str] = field(default_factory=list)
    """Reported with a failed test; tests may break requests themselves."""

    def watch(self, page: Page) -> None:
        """Follow a page from now on."""
        page.on("console", self._note_message)
        page.on("pageerror", self._note_error)
        page.on("request", self._note_request)
        page.on("requestfailed", self._note_failed_request)
        page.on("response", self._note_response)

    def unwatch(self, page: Page) -> None:
        """Stop following a page."""
        page.remove_listener("console", self._note_message)
        page.remove_listener("pageerror", self._note_error)
        page.remove_listener("request", self._note_request)
        page.remove_listener("requestfailed", self._note_failed_request)
        page.remove_listener("response", self._note_response)

    def _note_error(self, error: Error) -> None:
        self.errors.append(str(error))

    def _note_message(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.errors.append(message.text)

    def _note_request(self, request: Request) -> None:
        if not request.url.startswith(("http://127.0.0.1:", "data:", "blob:http://127.0.0.1:")):
            self.foreign_requests.append(request.url)

    def _note_failed_request(self, request: Request) -> None:
        self.failed_requests.append(f"{request.url}: {request.failure}")

    def _note_response(self, response: Response) -> None:
        if response.status >= 400:
            self.failed_requests.append(f"{response.url}: {response.status}")


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pluggy.Result[pytest.TestReport], None]:
    """Say with a failed test what its page has complained about: it is what tells why something was never shown."""
    outcome = yield
    record = getattr(item, "funcargs", {}).get("page_record")
    if isinstance(record, PageRecord) and (report := outcome.get_result()).failed:
        report.sections.append(("Page", "\n".join([*record.errors, *record.failed_requests])))


@pytest.fixture
def page_record() -> PageRecord:
    return PageRecord()


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def map_tab(browser: Browser) -> AsyncIterator[Page]:
    """The page with a map that all tests share: a page that is opened anew loads and compiles the dashboard again."""
    async with new_page(browser) as page:
        yield page


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def tab(browser: Browser) -> AsyncIterator[Page]:
    """The page without WebGL that all tests share."""
    async with new_page(browser) as page:
        await page.add_init_script(WITHOUT_WEBGL)
        yield page


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def other_tab(browser: Browser) -> AsyncIterator[Page]:
    """The same for those who look at a mission on a second screen."""
    async with new_page(browser) as page:
        await page.add_init_script(WITHOUT_WEBGL)
        yield page


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def axe_tab(browser: Browser) -> AsyncIterator[Page]:
    """The same for axe, which may be loaded into it; ours lets in no other scripts."""
    if not AXE.is_file():
        unavailable("axe is not installed: run npm ci in web/")
    context = await browser.new_context(viewport=VIEWPORT_PX, reduced_motion="reduce", bypass_csp=True)
    page = await context.new_page()
    page.set_default_timeout(TIMEOUT_MS)
    await page.add_init_script(WITHOUT_WEBGL)
    yield page
    await context.close()


@pytest_asyncio.fixture(loop_scope="session")
async def map_page(map_tab: Page, page_record: PageRecord) -> AsyncIterator[Page]:
    async with lent(map_tab, page_record):
        yield map_tab


@pytest_asyncio.fixture(loop_scope="session")
async def page(tab: Page, page_record: PageRecord) -> AsyncIterator[Page]:
    """A page in a browser without WebGL: everything but the map is as it is, and much faster without a GPU."""
    async with lent(tab, page_record):
        yield tab


@pytest_asyncio.fixture(loop_scope="session")
async def other_page(other_tab: Page) -> AsyncIterator[Page]:
    """A second screen, without WebGL too, with storage and cookies of its own."""
    async with lent(other_tab, PageRecord()):
        yield other_tab


@pytest_asyncio.fixture(loop_scope="session")
async def axe_page(axe_tab: Page) -> AsyncIterator[Page]:
    """A page without WebGL that axe can be loaded into."""
    async with lent(axe_tab, PageRecord()):
        yield axe_tab


@asynccontextmanager
async def new_page(browser: Browser, *, is_kept: bool = False) -> AsyncIterator[Page]:
    """Open a page of its own, for as long as the context is entered; its browser keeps its files only if asked to."""
    context = await browser.new_context(
        viewport=VIEWPORT_PX, reduced_motion="reduce", service_workers="allow" if is_kept else "block"
    )
    page = await context.new_page()
    page.set_default_timeout(TIMEOUT_MS)
    yield page
    await context.close()


@asynccontextmanager
async def lent(page: Page, record: PageRecord) -> AsyncIterator[None]:
    """Follow a shared page; afterwards it is empty, and as it was: nothing is stored, routed, emulated or pressed."""
    record.watch(page)
    yield
    record.unwatch(page)
    await page.mouse.up()
    await page.unroute_all(behavior="ignoreErrors")
    address = urlsplit(page.url)
    await page.goto("about:blank")
    if address.scheme == "http":
        await forget(page, f"http://{address.netloc}")
    await page.context.clear_cookies()
    await page.context.set_offline(False)
    await page.emulate_media(media="null")
    await page.set_viewport_size(VIEWPORT_PX)


async def forget(page: Page, origin: str) -> None:
    """Have the browser forget what the page has stored; it keeps files and what it has compiled of them."""
    session = await page.context.new_cdp_session(page)
    stored = {"origin": origin, "storageTypes": "local_storage,indexeddb,cache_storage"}
    await session.send("Storage.clearDataForOrigin", stored)
    await session.detach()


@cache
def usual_port() -> int:
    """The port of all missions of this process, one after another: a page at the same address is not compiled anew.

    It is odd, as those of :func:`unused_port` are even: nobody else takes it between two missions.
    """
    while True:
        port = unused_port(socket.SOCK_STREAM) + 1
        with socket.socket() as probe, suppress(OSError):  # in use by chance
            probe.bind(("127.0.0.1", port))
            return port


class Service:
    """A scripted mission behind the real server; can be stopped and started again on the same port."""

    def __init__(self, mission: ScriptedMission, make_app: Callable[[ScriptedMission], FastAPI], port: int) -> None:
        self.mission = mission
        self.url = ""
        self._make_app = make_app
        self._stop = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._port = port
        self._flying: asyncio.Task[None] | None = None

    def fly(self) -> None:
        """Let the mission's time pass."""
        self._flying = asyncio.create_task(self.mission.run(speed=_MISSION_SPEED))

    def freeze(self) -> None:
        """Stop the mission, and nothing else: the server does not notice."""
        if self._flying is not None:
            self._flying.cancel()

    async def start(self) -> None:
        """Listen; returns when requests are answered."""
        self._stop.clear()
        ready = asyncio.Event()
        self._task = asyncio.create_task(self._serve(ready))
        await asyncio.wait({self._task, waiting := asyncio.create_task(ready.wait())}, return_when="FIRST_COMPLETED")
        if self._task.done():
            waiting.cancel()
            self._task.result()

    async def stop(self) -> None:
        """Stop listening and close all connections."""
        if self._task is not None:
            self._stop.set()
            await self._task
            self._task = None

    async def _serve(self, ready: asyncio.Event) -> None:
        async with serve(self._make_app(self.mission), port=self._port) as address:
            self.url = address.url
            ready.set()
            await self._stop.wait()


@asynccontextmanager
async def serving(
    make_app: Callable[[ScriptedMission], FastAPI] = app_of, vehicles: int = 8, port: int | None = None
) -> AsyncIterator[Service]:
    """Serve a scripted mission for as long as the context is entered, on the usual port unless another one is given."""
    mission = ScriptedMission(LoopClock(), vehicles)
    service = Service(mission, make_app, usual_port() if port is None else port)
    await service.start()
    service.fly()
    try:
        yield service
    finally:  # also after a failed test: a server that is left behind would fail the next one
        service.freeze()
        await service.stop()


@pytest_asyncio.fixture(loop_scope="session")
async def service(dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - asked for its check only
    """A mission that everybody may command."""
    async with serving() as service:
        yield service


@pytest_asyncio.fixture(loop_scope="session")
async def guarded_service(dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - asked for its check only
    """A mission that only operators may command."""
    async with serving(partial(app_of, operator_code=OPERATOR_CODE)) as service:
        yield service


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def replay_service(
    tmp_path_factory: pytest.TempPathFactory,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
) -> AsyncIterator[tuple[ReplayedOperation, str]]:
    """Two sorties as ``aos-gcs replay`` serves them, with frames for the first step of the first; their address."""
    folder = tmp_path_factory.mktemp("replay")
    await record(folder / "mission")
    await record(folder / "second", vehicles=3, manifest={"operation": "mission", "sortie": 2})
    frames = await record_viewed_step(folder / "frames")
    with ReplayedOperation(folder / "mission", LoopClock()) as operation:
        mission = operation.replay
        viewer = Viewer(frames, ImagingSettings(), focus_reach_m=10.0)
        operation.keep("mission", viewer)
        app = create_app(mission, replay=mission, viewer=viewer, operation=operation, sortie_choice=operation)
        async with serve(app, port=0) as address:
            running = asyncio.create_task(mission.run())
            yield operation, address.url
            running.cancel()


@pytest_asyncio.fixture(loop_scope="session")
async def replayed(replay_service: tuple[ReplayedOperation, str]) -> str:
    """The address of a replay that stands at the beginning of the first sortie."""
    operation, url = replay_service
    await operation.show("mission")
    operation.replay.seek(time_s=0.0, speed=1.0, playing=False)
    return url
