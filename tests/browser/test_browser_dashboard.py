"""The dashboard in a real browser, against a scripted mission."""

from __future__ import annotations

import asyncio

import pytest
from playwright.async_api import Browser, Locator, Page, expect

from aos_gcs.mission.model import Action
from tests.fakes.mission import REFUSING_ID, SILENT_ID

START_TIMEOUT_MS = 15_000


async def open_page(page: Page, url: str) -> None:
    await page.goto(url)
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open", timeout=START_TIMEOUT_MS)


async def place_of(marker: Locator) -> tuple[str | None, str | None]:
    return await marker.get_attribute("data-east"), await marker.get_attribute("data-north")


async def wait_for_visibility(page: Page, lowest_m2: float) -> None:
    await page.wait_for_function(
        "lowest => Number(document.querySelector('[data-testid=visibility]')?.dataset.value) > lowest",
        arg=lowest_m2,
        timeout=40_000,
    )


async def test_page_shows_a_mission_without_errors_or_foreign_requests(page, service, page_record) -> None:
    await open_page(page, service.url)
    await expect(page.get_by_test_id("phase")).to_have_text("ready")
    await expect(page.get_by_test_id("preflight-problems")).to_contain_text("check its power and radio")
    await expect(page.get_by_test_id(f"link-{SILENT_ID}")).to_have_text("never heard")
    await expect(page.get_by_test_id(f"height-{SILENT_ID}")).to_have_text("\N{EN DASH}")
    marker = page.get_by_test_id("marker-1")
    await expect(marker).to_be_visible(timeout=START_TIMEOUT_MS)
    before = await place_of(marker)

    await page.get_by_test_id("action-start").click()
    await expect(page.get_by_test_id("phase")).to_have_text("scan", timeout=START_TIMEOUT_MS)
    await wait_for_visibility(page, 0.3)
    assert await place_of(marker) != before
    await expect(page.get_by_test_id("picture")).to_be_visible()
    await expect(page.get_by_test_id("marker-target")).to_be_visible()
    await expect(page.get_by_test_id("target-position")).to_contain_text("E ")
    assert page_record.errors == []
    assert page_record.foreign_requests == []


async def test_hold_never_asks_and_return_asks_once(page, service) -> None:
    await open_page(page, service.url)
    await page.get_by_test_id("action-start").click()
    await expect(page.get_by_test_id("phase")).to_have_text("line", timeout=START_TIMEOUT_MS)

    await page.get_by_test_id("action-hold").click()
    await expect(page.get_by_test_id("suspension")).to_have_text("held")
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")

    await page.get_by_test_id("action-return").click()
    await expect(page.get_by_test_id("confirm")).to_be_visible()
    await page.get_by_test_id("confirm-cancel").click()
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    assert [action for action, _ in service.mission.actions] == [Action.START, Action.HOLD]

    await page.get_by_test_id("action-return").click()
    await page.get_by_test_id("confirm-ok").click()
    await expect(page.get_by_test_id("phase")).to_have_text("return")
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    await expect(page.get_by_test_id(f"result-{REFUSING_ID}")).to_have_attribute("data-accepted", "false")
    await expect(page.get_by_test_id(f"result-{REFUSING_ID}")).to_contain_text("refused by the autopilot")


async def test_selection_is_the_scope_and_the_key_holds(page, service) -> None:
    await open_page(page, service.url)
    await page.get_by_test_id("action-start").click()
    await expect(page.get_by_test_id("phase")).to_have_text("line", timeout=START_TIMEOUT_MS)
    await page.get_by_test_id("select-3").check()
    await expect(page.get_by_test_id("scope")).to_have_text("vehicle 3")
    await expect(page.get_by_test_id("action-hold")).to_contain_text("Hold vehicle 3")
    await page.keyboard.press("h")
    await expect(page.get_by_test_id("result-3")).to_have_attribute("data-accepted", "true")
    await expect(page.get_by_test_id("task-3")).to_have_text("held")
    assert service.mission.actions[-1] == (Action.HOLD, (3,))


async def test_banner_says_disconnected_and_goes_when_the_service_is_back(page, service) -> None:
    await open_page(page, service.url)
    await service.stop()
    await expect(page.get_by_test_id("banner")).to_be_visible(timeout=2000)
    await expect(page.get_by_test_id("action-hold")).to_be_disabled()
    await service.start()
    await expect(page.get_by_test_id("banner")).to_have_count(0, timeout=START_TIMEOUT_MS)
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")


async def test_without_webgl_everything_else_works(browser: Browser, service) -> None:
    context = await browser.new_context()
    await context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page = await context.new_page()
    await open_page(page, service.url)
    await expect(page.get_by_test_id("map-message")).to_contain_text("WebGL")
    await expect(page.get_by_test_id("vehicle-1")).to_be_visible()
    await page.get_by_test_id("action-start").click()
    await expect(page.get_by_test_id("phase")).not_to_have_text("ready")
    await context.close()


@pytest.mark.parametrize("size", [(1280, 800), (1024, 768)], ids=str)
async def test_page_fits_the_screen(page: Page, service, size: tuple[int, int]) -> None:
    await page.set_viewport_size({"width": size[0], "height": size[1]})
    await open_page(page, service.url)
    await asyncio.wait_for(page.evaluate("document.fonts.ready.then(() => true)"), 5)
    overflow = await page.evaluate(
        "[document.documentElement.scrollWidth - innerWidth, document.documentElement.scrollHeight - innerHeight]"
    )
    assert max(overflow) <= 0
