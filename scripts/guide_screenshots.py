"""Take the pictures of docs/operator-guide.md again that a recorded mission can show.

Those of the start and the flight are taken by scripts/flight_screenshots.py.

    aos-gcs demo --vehicles 5 --seed 2 --headless --exit-when-done
    python scripts/guide_screenshots.py missions/FOLDER

Needs the packages of the extra `dev`, the dashboard's build, and Chromium (or its path in AOS_GCS_CHROMIUM).
"""

from __future__ import annotations

import argparse
import asyncio
import io
import os
import re
import shutil
import sys
from pathlib import Path

from PIL import Image
from playwright.async_api import Page, ViewportSize, async_playwright, expect

from aos_gcs.api.app import create_app
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.phase import Phase
from aos_gcs.runtime.recorded.viewer import open_viewer
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay

IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
DESKTOP = ViewportSize(width=1280, height=800)
TABLET = ViewportSize(width=800, height=1280)
LARGEST_BYTES = 300_000
PLAYED_S = 80.0
TIMEOUT_MS = 120_000
"""Maps without a graphics card take their time."""
CHROMIUM_ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]


async def main() -> None:
    """Serve the mission as `aos-gcs replay` does and look at it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path, help="folder of a recorded mission in which a target was found")
    parser.add_argument("--folder", type=Path, default=IMAGES, help="where the pictures go")
    parser.add_argument("--tablet", action="store_true", help="as a tablet held upright shows them")
    options = parser.parse_args()
    chromium = find_chromium()
    options.folder.mkdir(parents=True, exist_ok=True)
    with MissionReader(options.mission) as reader:
        mission = MissionReplay(reader, LoopClock())
        found_s = next((time_s for time_s, phase in mission.timeline().phases if phase is Phase.FOUND), None)
        if found_s is None:
            sys.exit(f"in {options.mission} no target was found: record another mission")
        app = create_app(mission, replay=mission, viewer=open_viewer(reader))
        async with serve(app, port=0) as address, async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=chromium, args=CHROMIUM_ARGUMENTS)
            page = await browser.new_page(viewport=TABLET if options.tablet else DESKTOP, color_scheme="dark")
            page.set_default_timeout(TIMEOUT_MS)
            expect.set_options(timeout=TIMEOUT_MS)
            await page.goto(address.url)
            await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
            playing = asyncio.create_task(mission.run())
            await play(mission, page, max(0.0, found_s - PLAYED_S))
            await shoot_all(page, options.folder)
            playing.cancel()
            await browser.close()


def find_chromium() -> str:
    """Return the browser's program, or end this one."""
    chromium = os.environ.get("AOS_GCS_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    return chromium or sys.exit("no Chromium found: install it, or name it in AOS_GCS_CHROMIUM")


async def play(mission: MissionReplay, page: Page, from_s: float) -> None:
    """Play the mission until its target is found, so that the page has seen how it came about."""
    mission.seek(time_s=from_s, speed=8.0, playing=True)
    await expect(page.get_by_test_id("phase")).to_have_text("Found")
    mission.seek(playing=False)


async def shoot_all(page: Page, folder: Path) -> None:
    """Take one picture of each view."""
    await page.get_by_test_id("map").locator(".maplibregl-ctrl-scale").wait_for()
    await page.wait_for_timeout(4000)  # MapLibre tells of nothing outside when it has drawn everything
    save(await page.screenshot(), folder / "replay.png")
    await page.get_by_test_id("view-see").click()
    await page.get_by_test_id("picture-thermal").click()
    await expect(page.get_by_test_id("picture-label")).to_contain_text(re.compile("Thermal.*plane at"))
    await page.locator(".stage-target circle").first.wait_for()
    place = await page.locator(".stage-target circle").first.bounding_box()
    if place is not None:
        await page.mouse.move(place["x"] + place["width"] / 2, place["y"] + place["height"] / 2)
        await page.mouse.wheel(0, -450)
    save(await page.screenshot(), folder / "see.png")
    await page.get_by_test_id("view-understand").click()
    await expect(page.get_by_test_id("visibility")).not_to_be_empty()
    save(await page.screenshot(), folder / "understand.png")


def save(screenshot: bytes, file: Path) -> None:
    """Save a picture in as many colours as let it be small enough for the documentation."""
    with Image.open(io.BytesIO(screenshot)) as image:
        colours = image.convert("RGB")
    for count in (256, 128, 64, 32):
        # Covers colours however few pixels have them: those of the page beside a large noisy picture.
        colours.quantize(count, method=Image.Quantize.MAXCOVERAGE).save(file, optimize=True)
        if file.stat().st_size <= LARGEST_BYTES:
            return


if __name__ == "__main__":
    asyncio.run(main())
