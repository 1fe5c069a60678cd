"""What goes wrong around a page: a map without a place, two operators with one plan, a clock that is a day off."""

from __future__ import annotations

import io
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from fastapi import FastAPI
from PIL import Image
from playwright.async_api import Browser, Page, expect

from aos_gcs.mission.model.actions import Action
from tests.browser.conftest import WITHOUT_WEBGL, PageRecord, Service, new_page, serving
from tests.browser.pages import open_page
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

pytestmark = pytest.mark.asyncio(loop_scope="session")

DAY_S = 86_400
SHIFTED_CLOCK = """const Real = Date;
window.Date = class extends Real {
    constructor(...given) { given.length ? super(...given) : super(Real.now() + AHEAD_MS); }
    static now() { return Real.now() + AHEAD_MS; }
};"""


async def test_a_geotiff_without_reference_is_refused_in_words(
    map_page: Page, service: Service, page_record: PageRecord
) -> None:
    picture = io.BytesIO()
    Image.new("RGB", (64, 64), "#e67814").save(picture, "TIFF")
    await open_page(map_page, service.url)
    await map_page.get_by_test_id("map-layers").click()
    chooser = map_page.get_by_test_id("basemap-file")
    await chooser.set_input_files({"name": "ortho.tif", "mimeType": "image/tiff", "buffer": picture.getvalue()})
    refusal = map_page.get_by_test_id("basemap-refusal")
    await expect(refusal).to_contain_text("ortho.tif is not a complete PMTiles file")
    await expect(refusal).to_contain_text("aos-gcs basemap")
    await expect(map_page.get_by_test_id("basemap-forget")).to_be_hidden()
    assert page_record.errors == []


@pytest_asyncio.fixture(loop_scope="session")
async def planned(tmp_path: Path, dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - its check
    def make_app(mission: ScriptedMission) -> FastAPI:
        return app_of(mission, plans_folder=tmp_path / "plans")

    async with serving(make_app) as service:
        yield service


async def test_two_operators_who_plan_at_once_lose_nothing(page: Page, other_page: Page, planned: Service) -> None:
    await open_page(page, planned.url, "plan")
    spacing = page.get_by_test_id("plan-layer_spacing_m")
    await spacing.fill("4")
    await open_page(other_page, planned.url, "plan")
    await other_page.get_by_test_id("plan-layer_spacing_m").fill("5")
    await expect(other_page.get_by_test_id("plan-apply")).to_be_enabled()
    await other_page.get_by_test_id("plan-apply").click()
    await expect(other_page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")
    await expect(page.get_by_test_id("plan-reload")).to_be_visible()
    await expect(spacing).to_have_value("4")
    await page.get_by_test_id("plan-reload").click()
    await expect(spacing).to_have_value("5")


@pytest.mark.parametrize("ahead_s", [DAY_S, -DAY_S])
async def test_a_page_whose_clock_is_a_day_off_shows_the_mission_and_commands_it(
    browser: Browser, service: Service, ahead_s: int
) -> None:
    async with new_page(browser) as page:
        await page.add_init_script(WITHOUT_WEBGL)
        await page.add_init_script(SHIFTED_CLOCK.replace("AHEAD_MS", str(1000 * ahead_s)))
        await open_page(page, service.url)
        await service.mission.act(Action.START, None)
        await expect(page.get_by_test_id("phase")).not_to_have_text("Ready")
        await expect(page.get_by_test_id("vehicle-1")).to_be_visible()
        await expect(page.locator(".page")).not_to_have_class("page is-old")
        await page.get_by_test_id("hold-all").click()
        await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    assert service.mission.actions[-1] == (Action.HOLD, None)
