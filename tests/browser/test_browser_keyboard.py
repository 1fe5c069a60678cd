"""Short ways for those who use the keyboard alone: keys lead into views, to findings, and confirm once."""

from __future__ import annotations

import pytest
from playwright.async_api import Page, expect

from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from tests.browser.conftest import Service
from tests.browser.pages import open_page, start_mission

pytestmark = pytest.mark.asyncio(loop_scope="session")

STEPS_UNTIL_FOUND = 20


async def test_a_key_that_opens_a_view_leads_into_it(page: Page, service: Service) -> None:
    await open_page(page, service.url)
    await page.keyboard.press("r")
    await expect(page.get_by_role("group", name="Launch")).to_be_focused()  # ready: the launch comes next
    await expect(page.get_by_test_id("launch")).to_be_enabled()
    await page.keyboard.press("Tab")
    await expect(page.get_by_test_id("launch")).to_be_focused()
    await page.keyboard.press("f")
    await expect(page.get_by_test_id("view-fly")).to_have_attribute("aria-current", "page")
    await page.keyboard.press("Tab")
    await expect(page.locator("main [data-testid]:focus")).to_have_count(1)


async def test_the_finding_of_an_alert_is_confirmed_by_three_keys(page: Page, service: Service) -> None:
    await service.mission.act(Action.START, None)
    for _ in range(STEPS_UNTIL_FOUND):
        service.mission.make_step()
    (finding,) = service.mission.findings.all()
    await open_page(page, service.url)
    await page.keyboard.press("n")
    await expect(page.get_by_test_id("view-fly")).to_have_attribute("aria-current", "page")  # nothing to show yet
    service.mission.notify(Severity.NEWS, "Possible person", track_id=finding.track_id)
    await expect(page.get_by_test_id("show-finding-1")).to_be_visible()
    await page.keyboard.press("n")
    await expect(page.get_by_role("group", name="Decision")).to_be_focused()
    # A busy machine may take the connection away for a moment: a button that is disabled then is passed over.
    await expect(page.get_by_test_id("judge-confirmed")).to_be_enabled()
    await page.keyboard.press("Tab")
    await expect(page.get_by_test_id("judge-confirmed")).to_be_focused()
    await page.keyboard.press("Enter")
    await expect(page.get_by_test_id("finding-status")).to_contain_text("confirmed")


@pytest.mark.parametrize("key", ["Enter", "Space"])
async def test_a_key_held_on_confirms_once_and_the_focus_comes_back(page: Page, service: Service, key: str) -> None:
    await open_page(page, service.url)
    await start_mission(page)
    await page.get_by_test_id("action-land").focus()
    await page.keyboard.press(key)
    await expect(page.get_by_test_id("confirm-cancel")).to_be_focused()
    await page.keyboard.press("Tab")
    await page.keyboard.down(key)
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    await expect(page.get_by_test_id("action-land")).to_be_focused()
    for _ in range(3):
        await page.keyboard.down(key)  # as it repeats
        await expect(page.get_by_test_id("confirm")).to_have_count(0)
    await page.keyboard.up(key)
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    assert service.mission.actions[1:] == [(Action.LAND, None)]
