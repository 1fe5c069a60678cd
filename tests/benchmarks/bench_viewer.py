"""Delay of the See view's slider: from its event to the new integral on the screen, and what that is spent on.

A recorded step of ten RGB+thermal frames of 512 x 512 behind the real server, the built page in Chromium without a
display. Needs the built page and Chromium (AOS_GCS_CHROMIUM, or one on the PATH).

Usage: ``python tests/benchmarks/bench_viewer.py [MOVES]``, by default 60 moves for each kind of picture.
"""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from bench_imaging import make_frames
from playwright.async_api import Page, async_playwright, expect
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.api.server import serve
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.runtime.recorded.viewer import Viewer
from tests.benchmarks.figures import report
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.viewed_step import record_step

ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]
SPACING_M = 3.0
KINDS = ("integral", "thermal", "anomaly", "coverage")
HEIGHTS_M = (-5.0, 20.0)
WARMING_MOVES = 3
DRAG_MOVES = 60
DRAG_INTERVAL_MS = 16.0

HELPERS = r"""() => {
    performance.setResourceTimingBufferSize(10000);
    const slider = document.querySelector('[data-testid=height]');
    const label = document.querySelector('[data-testid=picture-label]');
    // The picture and its label change together.
    window.isShown = (height_m) =>
        label.textContent.includes(`plane at ${height_m.toFixed(1).replace('-', '\u2212')}`);
    window.move = (height_m) => {
        slider.value = height_m;
        slider.dispatchEvent(new Event('input', { bubbles: true }));
    };
    // The frame after the change is drawn when the task behind its callback runs.
    window.painted = () => new Promise((done) => requestAnimationFrame(() => {
        const channel = new MessageChannel();
        channel.port1.onmessage = () => done(performance.now());
        channel.port2.postMessage(null);
    }));
    window.shown = async (height_m) => {
        await new Promise((done) => {
            const observer = new MutationObserver(() => {
                if (!window.isShown(height_m)) return;
                observer.disconnect();
                done();
            });
            observer.observe(label, { subtree: true, childList: true, characterData: true });
        });
        return window.painted();
    };
    // A picture that rests is exact: the next move's draft must not be taken for it.
    window.fetched = (since_ms) => performance.getEntriesByType('resource').filter(
        ({ name, startTime }) => name.includes('/integrals/') && startTime >= since_ms);
}"""

MOVE = """async (heights_m) => {
    const results = [];
    for (const height_m of heights_m) {
        performance.clearResourceTimings();
        const begun_ms = performance.now();
        const shown = window.shown(height_m);
        window.move(height_m);
        const painted_ms = await shown;
        while (window.fetched(begun_ms).length === 0) await new Promise((done) => setTimeout(done, 5));
        const { requestStart, responseStart, responseEnd, encodedBodySize } = window.fetched(begun_ms)[0];
        results.push({
            total: painted_ms - begun_ms,
            request: requestStart - begun_ms,
            server: responseStart - requestStart,
            transfer: responseEnd - responseStart,
            paint: painted_ms - responseEnd,
            kilobytes: encodedBodySize / 1000,
        });
    }
    return results;
}"""

DRAG = """async ([heights_m, interval_ms]) => {
    performance.clearResourceTimings();
    let moved_ms = 0;
    for (const height_m of heights_m) {
        moved_ms = performance.now();
        window.move(height_m);
        await new Promise((done) => setTimeout(done, interval_ms));
    }
    while (!window.isShown(heights_m.at(-1))) await new Promise((done) => requestAnimationFrame(done));
    const painted_ms = await window.painted();
    await new Promise((done) => setTimeout(done, 50));
    return { late_ms: painted_ms - moved_ms, fetched: window.fetched(0).length };
}"""

FORMATS = """async (heights_m) => {
    const times_ms = { jpg: [], png: [] };
    for (const height_m of heights_m)
        // Each is asked for on a plane of its own: what the server remembers of one would help the other.
        for (const [format, shift_m] of [['jpg', 0.001], ['png', 0.002]]) {
            const begun_ms = performance.now();
            const answer = await fetch(`/api/viewer/1/integrals/integral.${format}?height_m=${height_m + shift_m}`);
            const image = new Image();
            image.src = URL.createObjectURL(await answer.blob());
            await image.decode();
            URL.revokeObjectURL(image.src);
            times_ms[format].push(performance.now() - begun_ms);
        }
    return times_ms;
}"""


async def measure_moves(page: Page, kind: str, moves: int) -> tuple[list[dict[str, float]], float]:
    """Return the milliseconds of single moves of the slider, each to a plane that was not shown before.

    Beside them what a move takes of this process's processor time: on a machine that is busy with other things the
    clock says little about the program.
    """
    await page.get_by_test_id(f"picture-{kind}").click()
    await expect(page.get_by_test_id("picture-label")).to_contain_text(
        re.compile(f"{kind}, step 1, plane at", re.IGNORECASE)
    )
    await page.evaluate(HELPERS)
    index = KINDS.index(kind)
    # Shifted, so that none begins on the plane on which the one before has ended.
    planes_m = np.linspace(*HEIGHTS_M, moves + WARMING_MOVES) + 0.1 * index
    heights_m = np.random.default_rng(index).permutation(planes_m).round(1).tolist()
    await page.evaluate(MOVE, heights_m[:WARMING_MOVES])
    begun_s = time.process_time()
    results: list[dict[str, float]] = await page.evaluate(MOVE, heights_m[WARMING_MOVES:])
    return results, 1e3 * (time.process_time() - begun_s) / moves


async def measure_formats(page: Page, moves: int) -> dict[str, float]:
    """Return the median milliseconds from a request to the decoded picture, drafts and exact ones in turn."""
    heights_m = np.random.default_rng(9).permutation(np.linspace(*HEIGHTS_M, moves)).round(2).tolist()
    times_ms: dict[str, list[float]] = await page.evaluate(FORMATS, heights_m)
    return {name: float(np.median(times)) for name, times in times_ms.items()}


async def measure_drag(page: Page) -> dict[str, Any]:
    """Return how late the last picture of a fast drag is, and how many were asked for on the way."""
    heights_m = np.linspace(-3.0, 12.0, DRAG_MOVES).round(1)
    result: dict[str, Any] = await page.evaluate(DRAG, [heights_m.tolist(), DRAG_INTERVAL_MS])
    return result


def row(kind: str, results: Sequence[dict[str, float]], cpu_ms: float) -> list[str]:
    """Return the medians of moves as a row of the table."""
    columns = {name: np.array([result[name] for result in results]) for name in results[0]}
    shares = [f"{np.median(columns[name]):.0f}" for name in ("request", "server", "transfer", "paint", "kilobytes")]
    total = columns["total"]
    return [kind, f"{np.median(total):.0f}", f"{np.percentile(total, 95):.0f}", *shares, f"{cpu_ms:.0f}"]


async def run(moves: int, folder: Path) -> None:
    """Print the figures."""
    frames = [replace(frame, vehicle_id=frame.vehicle_id + 1) for frame in make_frames(SPACING_M, np.float32)]
    viewer = Viewer(await record_step(folder, frames), ImagingSettings(), focus_reach_m=10.0)
    mission = ScriptedMission(HandClock())
    mission.make_step()
    chromium = os.environ.get("AOS_GCS_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    async with serve(app_of(mission, viewer=viewer), port=0) as address, async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        page = await browser.new_page(viewport={"width": 1280, "height": 800})
        await page.goto(f"{address.url}#/see")
        await expect(page.get_by_test_id("latency")).to_be_visible()
        table = Table("picture", "median", "p95", "request", "server", "transfer", "decode, paint", "kB", "server CPU")
        for kind in KINDS:
            results, cpu_ms = await measure_moves(page, kind, moves)
            table.add_row(*row(kind, results, cpu_ms))
            if kind == "integral":
                report("viewer.plane", float(np.median([result["total"] for result in results])))
        Console(width=110).print(
            f"From the slider's event to the painted picture, {moves} moves each, milliseconds:", table
        )
        for _ in range(3):
            drag = await measure_drag(page)
            print(
                f"drag of {DRAG_MOVES} moves in {DRAG_MOVES * DRAG_INTERVAL_MS / 1000:.1f} s: {drag['fetched']} planes "
                f"asked for, {DRAG_MOVES - drag['fetched']} left out, the last one {drag['late_ms']:.0f} ms late"
            )
        formats_ms = await measure_formats(page, moves)
        print(
            f"from the request to the decoded integral, in turn: a draft (jpg) {formats_ms['jpg']:.0f} ms, an exact "
            f"picture (png) {formats_ms['png']:.0f} ms"
        )
        await browser.close()


def main(arguments: Sequence[str]) -> None:
    """Measure with the number of moves of the command line."""
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(run(int(arguments[0]) if arguments else 60, Path(folder)))


if __name__ == "__main__":
    main(sys.argv[1:])
