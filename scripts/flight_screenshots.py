"""Take the pictures of README.md and docs/operator-guide.md again that show the launch and the flight.

    python scripts/flight_screenshots.py

Flies a demo of its own, as an operator does with the page. Needs what scripts/guide_screenshots.py needs.
"""

from __future__ import annotations

import argparse
import asyncio
import re
import sys
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from guide_screenshots import CHROMIUM_ARGUMENTS, DESKTOP, IMAGES, TIMEOUT_MS, find_chromium, save
from playwright.async_api import Page, async_playwright, expect

ADDRESS = re.compile(r"http://\S+#\S+")
CONVERGED_STEPS = 4
"""Steps after the first sign of a target: the swarm has begun to gather."""
ZOOMS = 1
"""Times that the map is enlarged, which shows the whole geofence at first."""


async def main() -> None:
    """Fly the demo and look at it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=IMAGES, help="where the pictures go")
    parser.add_argument("--vehicles", type=int, default=10)
    parser.add_argument("--seed", type=int, default=2)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    chromium = find_chromium()
    async with demo(options.vehicles, options.seed) as address, async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=chromium, args=CHROMIUM_ARGUMENTS)
        page = await browser.new_page(viewport=DESKTOP, color_scheme="dark")
        page.set_default_timeout(TIMEOUT_MS)
        expect.set_options(timeout=TIMEOUT_MS)
        await page.goto(address)
        await page.get_by_test_id("sign-in-name").fill("Ada")
        await page.get_by_test_id("sign-in-ok").click()
        await shoot_preparation(page, options.folder / "prepare.png")
        await shoot_flight(page, options.folder / "dashboard.png")
        await browser.close()


@asynccontextmanager
async def demo(vehicles: int, seed: int) -> AsyncIterator[str]:
    """Run a demo that waits for its operator; yield the address for operators."""
    program = ("-m", "aos_gcs", "demo", "--wait", "--vehicles", str(vehicles), "--seed", str(seed))
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "demo.log").open("w+b") as log:
        process = await asyncio.create_subprocess_exec(sys.executable, *program, cwd=folder, stdout=log, stderr=log)
        try:
            while not (found := ADDRESS.search(printed(Path(log.name)))):
                if process.returncode is not None:
                    sys.exit("the demo ended before it had printed an address for operators")
                await asyncio.sleep(0.2)
            yield found[0]
        finally:
            if process.returncode is None:
                process.kill()
            await process.wait()


def printed(log: Path) -> str:
    """Return what a program has printed so far."""
    return log.read_text(encoding="utf-8")


async def shoot_preparation(page: Page, file: Path) -> None:
    """Take the matrix of a preflight that has passed."""
    await page.get_by_test_id("view-prepare").click()
    await expect(page.get_by_test_id("phase")).to_have_text("Ready")
    await page.mouse.move(0, 0)
    save(await page.screenshot(), file)


async def shoot_flight(page: Page, file: Path) -> None:
    """Launch, and take the map while the swarm gathers."""
    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("action-start").click()
    await page.get_by_test_id("confirm-ok").hover()
    await page.mouse.down()
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    await page.mouse.up()
    await expect(page.get_by_test_id("phase")).to_have_text("Converging")
    step = int(await page.get_by_test_id("step").inner_text())
    condition = "number => Number(document.querySelector('[data-testid=step]').textContent) >= number"
    await page.wait_for_function(condition, arg=step + CONVERGED_STEPS)
    for _ in range(ZOOMS):
        await page.get_by_role("button", name="Zoom in").click()
    await page.wait_for_timeout(2000)  # the map draws the step
    save(await page.screenshot(), file)


if __name__ == "__main__":
    asyncio.run(main())
