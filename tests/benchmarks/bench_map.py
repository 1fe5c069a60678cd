"""Fluidity of the map: frames per second while it is dragged and zoomed over a large searched area.

Ten vehicles fly at 5 Hz over 81 ha that are shown as searched, with the ground's picture, behind the real server;
Chromium shows the view Fly without a display and without a graphics card, so that the processor draws the map. What the
page's main thread takes of the processor for a frame is told beside the frames that come. Needs the built page and
Chromium (AOS_GCS_CHROMIUM, or one on the PATH).

Usage: ``python tests/benchmarks/bench_map.py [SECONDS]``, by default 10 s for each gesture.
"""

from __future__ import annotations

import asyncio
import math
import os
import shutil
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import cv2
import numpy as np
from bench_dashboard import ARGUMENTS, RATE_HZ, main_thread_tasks, tracing
from playwright.async_api import Page, async_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import EventKind, PicturesRecord
from aos_gcs.mission.model.steps import Picture, PictureKind
from tests.benchmarks.figures import report
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

VEHICLES = 10
HALF_WIDTH_M = 450.0
CELLS = 1000
"""Cells of a picture of searched ground along an edge, as large as the station makes them."""
GESTURES_HZ = 60.0
RADIUS_PX = 200.0
TURN_S = 2.0
"""Duration of a circle of the hand, or of zooming in and out."""
SETTLING_S = 8.0
FRAMES = """() => {
    window.frames_ms = [];
    const note = (now_ms) => { window.frames_ms.push(now_ms); window.noting = requestAnimationFrame(note); };
    window.noting = requestAnimationFrame(note);
}"""
Gesture = Callable[[Page, float, float, float], Awaitable[None]]
"""What a hand does around a place on the page, x and y in pixels, for some seconds."""
STOP = "() => { cancelAnimationFrame(window.noting); return window.frames_ms; }"


class SearchedHectares(ScriptedMission):
    """Shows pictures of 81 ha, in which each step changes what is shown."""

    def _publish_pictures(self, number: int) -> None:
        bounds = (-HALF_WIDTH_M, -HALF_WIDTH_M, HALF_WIDTH_M, HALF_WIDTH_M)
        rng = np.random.default_rng(number)
        for kind in PictureKind:
            rgba = rng.integers(0, 256, (CELLS // 10, CELLS // 10, 4), np.uint8)
            rgba = np.asarray(cv2.resize(rgba, (CELLS, CELLS), interpolation=cv2.INTER_CUBIC), np.uint8)
            png = cv2.imencode(".png", rgba, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
            self._pictures[kind] = Picture(kind, number, png, *bounds)
        self.stream.publish(EventKind.PICTURES, PicturesRecord(number, tuple(PictureKind), *bounds))


async def paced(seconds: float) -> AsyncIterator[float]:
    """Yield the time since the beginning, seconds, as often as a hand is noted."""
    begun_s = time.perf_counter()
    while (elapsed_s := time.perf_counter() - begun_s) < seconds:
        yield elapsed_s
        await asyncio.sleep(1 / GESTURES_HZ)


async def drag(page: Page, x_px: float, y_px: float, seconds: float) -> None:
    """Drag the map in circles."""
    await page.mouse.move(x_px + RADIUS_PX, y_px)
    await page.mouse.down()
    async for elapsed_s in paced(seconds):
        angle = 2 * math.pi * elapsed_s / TURN_S
        await page.mouse.move(x_px + RADIUS_PX * math.cos(angle), y_px + RADIUS_PX * math.sin(angle))
    await page.mouse.up()


async def zoom(page: Page, x_px: float, y_px: float, seconds: float) -> None:
    """Zoom in and out with the wheel."""
    await page.mouse.move(x_px, y_px)
    async for elapsed_s in paced(seconds):
        await page.mouse.wheel(0.0, 20.0 * math.copysign(1.0, math.sin(2 * math.pi * elapsed_s / TURN_S)))


async def rest(page: Page, x_px: float, y_px: float, seconds: float) -> None:
    """Let the hand rest."""
    del page, x_px, y_px
    await asyncio.sleep(seconds)


async def measure(page: Page, name: str, gesture: Gesture, seconds: float) -> float:
    """Print the frames of a gesture and return the mean of their intervals, milliseconds."""
    box = await page.locator(".maplibregl-canvas").bounding_box()
    assert box is not None
    browser = page.context.browser
    assert browser is not None
    await page.evaluate(FRAMES)
    async with tracing(browser) as events:
        await gesture(page, box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, seconds)
    intervals_ms = np.diff(await page.evaluate(STOP))
    cpu_ms = np.array([task.get("tdur", 0) / 1000 for task in main_thread_tasks(events)])
    median_ms, slow_ms = np.percentile(intervals_ms, (50, 95))
    print(
        f"{name}: {1000 / intervals_ms.mean():.1f} frames per second; intervals median {median_ms:.1f} ms, "
        f"95th percentile {slow_ms:.0f} ms, longest {intervals_ms.max():.0f} ms; main thread "
        f"{cpu_ms.sum() / len(intervals_ms):.1f} ms of processor per frame, longest task {cpu_ms.max():.0f} ms"
    )
    return float(intervals_ms.mean())


async def run(seconds: float) -> None:
    """Print the figures."""
    chromium = os.environ.get("AOS_GCS_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    mission = SearchedHectares(LoopClock(), VEHICLES)
    async with serve(app_of(mission), port=0) as address, async_playwright() as playwright:
        flying = asyncio.create_task(mission.run(1 / RATE_HZ))
        browser = await playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        page = await browser.new_page(viewport={"width": 1280, "height": 800})
        await page.goto(f"{address.url}#/fly")
        await mission.act(Action.START, None)
        await asyncio.sleep(SETTLING_S)
        await page.wait_for_selector("[data-testid=searched-legend]")
        await measure(page, "at rest", rest, seconds)
        report("map.drag", await measure(page, "dragged", drag, seconds))
        report("map.zoom", await measure(page, "zoomed", zoom, seconds))
        if picture := os.environ.get("AOS_GCS_PICTURE"):
            await page.screenshot(path=picture)
        await browser.close()
        flying.cancel()


if __name__ == "__main__":
    asyncio.run(run(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0))
