"""The dashboard with a large fleet: what its page costs, and how old the values on the screen are.

A scripted mission flies many vehicles behind the real server, Chromium shows the view Fly without a display. Needs the
built page and Chromium (AOS_GCS_CHROMIUM, or one on the PATH).

Usage: ``python tests/benchmarks/bench_dashboard.py [VEHICLES] [SECONDS]``, by default 100 vehicles for 20 s.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from playwright.async_api import Browser, CDPSession, Page, async_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.snapshot import MissionSnapshot
from tests.benchmarks.figures import report
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

RATE_HZ = 5.0
LOADS = 5
SETTLING_S = 8.0
"""Take-off and the first steps, with the pictures' first loading."""
REST_S = 6.0
"""The other views, which the page loads three seconds after it is there."""
LONG_TASK_MS = 100.0
ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]
WATCH = """() => {
    window.delays = [];
    const shown = document.querySelector('[data-testid=message]');
    new MutationObserver(() => window.delays.push(Date.now() - Number(shown.textContent)))
        .observe(shown, { childList: true, characterData: true, subtree: true });
}"""
LOADED = "count => document.querySelectorAll('[data-testid^=vehicle-]').length === count"


class StampedMission(ScriptedMission):
    """Says in its message when a snapshot was made, so that the page can tell how late it shows it."""

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        return replace(super().snapshot(), message=f"{time.time() * 1000:.0f}")


async def sent_kb(browser: Browser, url: str, vehicles: int, locale: str, encoding: str) -> tuple[float, float]:
    """Return what is sent, with the headers of the answers, to a page that knows nothing yet.

    Returns:
        Until it shows its vehicles and the map; and when it has loaded what it may need later, too.

    Browsers accept Brotli from the same machine and over HTTPS only; else they get gzip.
    """
    context = await browser.new_context(locale=locale, extra_http_headers={"Accept-Encoding": encoding})
    page = await context.new_page()
    session = await context.new_cdp_session(page)
    await session.send("Network.enable")
    sent: dict[str, int] = {}
    session.on("Network.loadingFinished", lambda event: sent.update({event["requestId"]: event["encodedDataLength"]}))
    await page.goto(f"{url}#/fly")
    await page.wait_for_function(LOADED, arg=vehicles)
    await page.wait_for_selector(".maplibregl-canvas")
    await asyncio.sleep(1.0)  # what is fetched beside that: state of the session, base map, icon
    first_kb = sum(sent.values()) / 1000
    await asyncio.sleep(REST_S)
    await context.close()
    return first_kb, sum(sent.values()) / 1000


async def load_s(page: Page, url: str, vehicles: int) -> float:
    """Return how long the page takes from the request to a table with all vehicles."""
    await page.goto("about:blank")
    begun_s = time.perf_counter()
    await page.goto(f"{url}#/fly")
    await page.wait_for_function(LOADED, arg=vehicles)
    return time.perf_counter() - begun_s


async def measure(browser: Browser, page: Page, seconds: float) -> dict[str, float]:
    """Return what the page's main thread has done meanwhile: shares of a core, tasks and delays, milliseconds.

    What a task takes of the processor is told beside what it takes by the clock: on a machine that is busy with other
    things the latter says nothing about the page.
    """
    session = await page.context.new_cdp_session(page)
    await session.send("Performance.enable", {"timeDomain": "threadTicks"})
    await page.evaluate(WATCH)
    before, begun_s = await counters(session), time.perf_counter()
    async with tracing(browser) as events:
        await asyncio.sleep(seconds)
    after, wall_s = await counters(session), time.perf_counter() - begun_s
    tasks = main_thread_tasks(events)
    wall_ms, cpu_ms = ([task.get(name, 0) / 1000 for task in tasks] for name in ("dur", "tdur"))
    delays_ms = await page.evaluate("window.delays")
    names = ("TaskDuration", "ScriptDuration", "LayoutDuration", "RecalcStyleDuration")
    shares = {f"{name}_percent": 100 * (after[name] - before[name]) / wall_s for name in names}
    return shares | {
        "updates_hz": len(delays_ms) / wall_s,
        "delay_median_ms": float(np.median(delays_ms)),
        "delay_p95_ms": float(np.percentile(delays_ms, 95)),
        "tasks_over_100_ms": sum(duration_ms > LONG_TASK_MS for duration_ms in wall_ms),
        "longest_task_ms": max(wall_ms),
        "longest_task_cpu_ms": max(cpu_ms),
        "heap_mb": after["JSHeapUsedSize"] / 1e6,
    }


@asynccontextmanager
async def tracing(browser: Browser) -> AsyncIterator[list[dict[str, Any]]]:
    """Collect Chromium's own events while the context is entered; they are complete when it has been left."""
    session = await browser.new_browser_cdp_session()
    events: list[dict[str, Any]] = []
    complete = asyncio.Event()
    session.on("Tracing.dataCollected", lambda data: events.extend(data["value"]))
    session.on("Tracing.tracingComplete", lambda _: complete.set())
    config = {"includedCategories": ["toplevel"]}
    await session.send("Tracing.start", {"traceConfig": config, "transferMode": "ReportEvents"})
    yield events
    await session.send("Tracing.end")
    await complete.wait()


def main_thread_tasks(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the tasks of the page's main thread."""
    threads = {
        (event["pid"], event["tid"])
        for event in events
        if event["name"] == "thread_name" and event["args"]["name"] == "CrRendererMain"
    }
    return [
        event
        for event in events
        if event["name"] == "ThreadControllerImpl::RunTask"
        and (event["pid"], event["tid"]) in threads
        and "dur" in event
    ]


async def counters(session: CDPSession) -> dict[str, float]:
    """Return Chromium's counters."""
    answer = await session.send("Performance.getMetrics")
    return {metric["name"]: metric["value"] for metric in answer["metrics"]}


async def run(vehicles: int, seconds: float) -> None:
    """Print the figures."""
    chromium = os.environ.get("AOS_GCS_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    mission = StampedMission(LoopClock(), vehicles)
    async with serve(app_of(mission), port=0) as address, async_playwright() as playwright:
        flying = asyncio.create_task(mission.run(1 / RATE_HZ))
        browser = await playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        kb = {
            (locale, encoding): await sent_kb(browser, address.url, vehicles, locale, encoding)
            for locale in ("en", "de")
            for encoding in ("gzip", "br")
        }
        report("dashboard.size", kb["en", "gzip"][0])
        for kind, (first_kb, all_kb) in kb.items():
            print(f"sent ({', '.join(kind)}): {first_kb:.1f} kB, with the other views {all_kb:.1f} kB")
        page = await browser.new_page(viewport={"width": 1280, "height": 800})
        loads_s = [await load_s(page, address.url, vehicles) for _ in range(LOADS)]
        report("dashboard.load", loads_s[0])
        print(f"load: first {loads_s[0]:.2f} s, median of {LOADS} {np.median(loads_s):.2f} s")
        await mission.act(Action.START, None)
        await asyncio.sleep(SETTLING_S)
        figures = await measure(browser, page, seconds)
        report("dashboard.main_thread", figures["TaskDuration_percent"])
        print(f"{vehicles} vehicles at {RATE_HZ:g} Hz for {seconds:g} s; percent are of a core:")
        print(json.dumps({name: round(value, 1) for name, value in figures.items()}, indent=2))
        await browser.close()
        flying.cancel()


if __name__ == "__main__":
    asyncio.run(run(int(sys.argv[1]) if len(sys.argv) > 1 else 100, float(sys.argv[2]) if len(sys.argv) > 2 else 20.0))
