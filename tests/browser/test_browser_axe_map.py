"""Views with a map: axe finds nothing but minor issues, forced colours and reduced motion included."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from tests.browser.conftest import AXE, Service
from tests.browser.pages import open_page
from tests.browser.test_browser_accessibility import CONTRAST, axe_issues

pytestmark = pytest.mark.asyncio(loop_scope="session")

VIEWS = ("fly", "plan", "decide")
"""Views with a map."""
MOVING = """() => document.getAnimations({ subtree: true })
    .filter(one => one.playState === "running" && one.effect.getComputedTiming().duration > 1)
    .map(one => `${one.effect.target?.className} ${one.animationName ?? one.transitionProperty}`)"""
"""Animations that run for longer than a millisecond."""


@pytest_asyncio.fixture(loop_scope="session")
async def mapped_page(browser: Browser) -> AsyncIterator[Page]:
    """A page with a map that axe may be loaded into."""
    context = await browser.new_context(viewport={"width": 1280, "height": 800}, bypass_csp=True)
    page = await context.new_page()
    yield page
    await context.close()


async def test_axe_finds_no_issue_with_the_map_while_the_mission_is_silent(mapped_page: Page, service: Service) -> None:
    page = mapped_page
    await open_page(page, service.url)
    await page.add_script_tag(path=AXE)
    await service.mission.act(Action.START, None)
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    await expect(page.get_by_test_id("alert-bar")).to_be_visible()
    # Its banner is the largest that the page has; and most of the time would go into drawing the map again.
    service.freeze()
    await expect(page.locator(".banner")).to_be_visible()
    found: dict[str, list[str]] = {}
    for view in VIEWS:  # the map of a view is made once, and takes other colours
        await page.get_by_test_id(f"view-{view}").click()
        await expect(page.get_by_test_id(f"view-{view}")).to_have_attribute("aria-current", "page")
        for theme in ("light", "dark"):
            await page.get_by_test_id("settings-open").click()
            await page.get_by_test_id(f"theme-{theme}").click()
            await page.get_by_test_id("settings-close").click()
            await expect(page.locator(".map-canvas canvas")).to_be_visible()
            found[f"{view}, {theme}"] = await axe_issues(page, *(CONTRAST if theme == "dark" else ()))
        await page.emulate_media(forced_colors="active", reduced_motion="reduce")
        # Colours are the system's own there: contrast is not the page's to keep.
        found[f"{view}, forced colours"] = await axe_issues(page, "cat.aria", "cat.name-role-value", "cat.keyboard")
        found[f"{view}, reduced motion"] = await page.evaluate(MOVING)
        await page.emulate_media(forced_colors="none", reduced_motion="no-preference")
    assert {where: issues for where, issues in found.items() if issues} == {}
