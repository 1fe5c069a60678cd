"""Delay of a finding to the page: from the mission to the frame of the browser after the one that has painted it.

    python tests/benchmarks/bench_finding.py [--findings 30]

The dashboard runs in its own process, as in missions, and shows a scripted mission of this one in Chromium.
"""

from __future__ import annotations

import argparse
import asyncio
import shutil
import statistics
import tempfile
import time
from pathlib import Path

from playwright.async_api import async_playwright

from aos_gcs.mission.model.actions import Action
from tests.fakes.api_process import station

_CHROMIUM_ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu"]

# Notes for each finding of the list when the frame after its first one was drawn.
_WATCH_LIST = """() => {
    window.shown = {};
    const look = () => {
        for (const { dataset } of document.querySelectorAll("[data-testid^='finding-']")) {
            const name = dataset.testid;
            if (name in window.shown) continue;
            window.shown[name] = 0;
            requestAnimationFrame(() => setTimeout(() => { window.shown[name] = Date.now() / 1000; }));
        }
    };
    new MutationObserver(look).observe(document.body, { childList: true, subtree: true, attributes: true });
    look();
}"""


async def measure(findings: int, chromium: str) -> None:
    """Mark places, one after the other, and print how late the page shows them."""
    delays_s = []
    with tempfile.TemporaryDirectory() as name:
        async with station(Path(name)) as flown, async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=shutil.which(chromium), args=_CHROMIUM_ARGUMENTS)
            page = await browser.new_page(viewport={"width": 1920, "height": 1080})
            await page.goto(f"{flown.url}#/decide")
            await page.get_by_test_id("findings").wait_for()
            await flown.mission.act(Action.START, None)
            await page.evaluate(_WATCH_LIST)
            for number in range(findings):
                await asyncio.sleep(0.61 + 0.07 * (number % 10))
                began_s = time.time()
                found = await flown.mission.add_finding((10.0, 20.0, 0.0), "", operator="Ada")
                shown = f"() => window.shown['finding-{found.finding_id}'] || 0"
                await page.wait_for_function(shown, timeout=20_000, polling=20)
                delays_s.append(float(await page.evaluate(shown)) - began_s)
            await browser.close()
    ordered_s = sorted(delays_s)
    print(f"{findings} findings, from the mission to the page: ", end="")
    print(f"median {1000.0 * statistics.median(ordered_s):.0f} ms, longest {1000.0 * ordered_s[-1]:.0f} ms")


def main() -> None:
    """Read the options and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--findings", type=int, default=30)
    parser.add_argument("--chromium", default="chromium", help="Program of the browser.")
    options = parser.parse_args()
    asyncio.run(measure(options.findings, options.chromium))


if __name__ == "__main__":
    main()
