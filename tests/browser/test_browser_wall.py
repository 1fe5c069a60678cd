"""The view Wall: live pictures that are chosen, followed, and marked when they are old."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from fastapi import FastAPI
from playwright.async_api import Page, expect

from aos_gcs.clock import machine_utc_s
from tests.browser.conftest import AXE, OPERATOR_CODE, PageRecord, Service, serving
from tests.browser.pages import open_page, sign_in
from tests.browser.test_browser_accessibility import axe_issues
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.videos import ScriptedVideos
from tests.fakes.wall import CountedWorker, GrowingRecord, make_wall

pytestmark = pytest.mark.asyncio(loop_scope="session")

STALE_S = 3.0
BANDS = ("red", "green", "blue", "thermal")


@asynccontextmanager
async def cameras(folder: Path) -> AsyncIterator[tuple[Service, set[int]]]:
    """Serve a mission of two cameras; those in the set take two frames per second."""
    record = GrowingRecord(folder)
    working = {1, 2}

    def make_app(mission: ScriptedMission) -> FastAPI:
        wall = make_wall(mission, record.folder, CountedWorker(), clock_utc_s=machine_utc_s, stale_s=STALE_S)
        return app_of(mission, wall=wall, videos=ScriptedVideos())

    async def take() -> None:
        while True:
            for vehicle_id in working:
                record.add(vehicle_id, machine_utc_s(), bands=BANDS)
            await asyncio.sleep(0.5)

    taking = asyncio.create_task(take())
    async with serving(make_app) as service:
        yield service, working
    taking.cancel()
    record.close()


async def test_tiles_are_chosen_followed_and_grow_old(
    axe_page: Page,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
    tmp_path: Path,
) -> None:
    page = axe_page
    async with cameras(tmp_path) as (service, working):
        await open_page(page, service.url, "wall")
        await page.add_script_tag(path=AXE)
        tile = page.get_by_test_id("tile-1.thermal")
        await expect(tile).to_have_attribute("data-state", "live")
        await expect(tile).to_contain_text(re.compile(r"48\.\d{6}° N, 14\.\d{6}° E"))
        await expect(tile).to_contain_text(re.compile(r"\d\d:\d\d:\d\d .*ago"))
        await expect(tile).to_contain_text("12.0\u202f°C to 34.0\u202f°C")
        await _shows_its_picture(page)
        assert await axe_issues(page) == []
        await page.get_by_test_id("choose-2.colour").check()
        await expect(page.get_by_test_id("tile-2.colour")).to_have_attribute("data-state", "live")
        await page.get_by_test_id("choose-2.thermal").uncheck()
        await expect(page.get_by_test_id("tile-2.thermal")).to_have_count(0)
        working.discard(2)
        await expect(page.get_by_test_id("tile-2.colour")).to_have_attribute("data-state", "old")
        await expect(page.get_by_test_id("tile-2.colour")).to_contain_text("Outdated image")
        await expect(tile).to_have_attribute("data-state", "live")
        assert await axe_issues(page, "color-contrast") == []
        await page.get_by_test_id("follow-1.thermal").press("Enter")
        followed = page.get_by_test_id("follow").get_by_test_id("tile-1.thermal")
        await expect(followed).to_have_attribute("data-state", "live")
        await expect(page.get_by_test_id("dialog-hold-all")).to_be_visible()
        assert await axe_issues(page) == []
        await page.get_by_test_id("follow-close").click()
        await expect(page.get_by_test_id("follow")).to_have_count(0)
        await expect(tile).to_have_attribute("data-state", "live")
        await service.stop()
        await expect(tile).to_have_attribute("data-state", "old")
        await service.start()
        await expect(tile).to_have_attribute("data-state", "live")
        await expect(page.get_by_test_id("tile-2.thermal")).to_have_count(0)


async def test_a_video_is_made_cancelled_refused_and_downloaded(
    page: Page,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
    page_record: PageRecord,
    tmp_path: Path,
) -> None:
    record, videos = GrowingRecord(tmp_path), ScriptedVideos()

    def make_app(mission: ScriptedMission) -> FastAPI:
        wall = make_wall(mission, record.folder, CountedWorker(), clock_utc_s=machine_utc_s)
        return app_of(mission, wall=wall, videos=videos, operator_code=OPERATOR_CODE)

    async with serving(make_app) as service:
        await open_page(page, service.url, "wall")
        await expect(page.get_by_test_id("wall-choice")).to_be_visible()
        await expect(page.get_by_test_id("video-make")).to_have_count(0)  # for observers
        await page.get_by_test_id("sign-in-open").click()
        await sign_in(page, "Ada", OPERATOR_CODE)
        await page.get_by_test_id("video-make").click()
        await expect(page.get_by_test_id("video-progress")).to_be_visible()
        videos.advance(0.42)
        await expect(page.get_by_test_id("wall-video")).to_contain_text(re.compile("42.%"))
        await page.get_by_test_id("video-cancel").click()
        await expect(page.get_by_test_id("video-make")).to_be_visible()
        await page.get_by_test_id("video-make").click()
        await expect(page.get_by_test_id("video-progress")).to_be_visible()
        videos.fail("The video cannot be written: No space left on device.")
        await expect(page.get_by_test_id("video-problem")).to_contain_text("No space left on device")
        await page.get_by_test_id("video-make").click()
        await expect(page.get_by_test_id("video-progress")).to_be_visible()
        async with page.expect_download() as downloading:
            videos.finish()
        download = await downloading.value
        assert download.suggested_filename == "wall-scripted-1.mp4"
        assert (await download.path()).read_bytes() == ScriptedVideos.FILE
        await expect(page.get_by_test_id("wall-video")).to_contain_text("01:23")
        await expect(page.get_by_test_id("video-problem")).to_be_empty()
    record.close()
    page_record.errors.clear()  # the browser's word on the service that is gone


async def _shows_its_picture(page: Page) -> None:
    """Wait until the warm spot of the camera is painted."""
    spot = """() => {
        const canvas = document.querySelector("[data-testid='tile-1.thermal'] canvas");
        const [red, green] = canvas.getContext("2d").getImageData(20, 20, 1, 1).data;
        return red > 200 && green > 200;
    }"""
    await page.wait_for_function(spot)
