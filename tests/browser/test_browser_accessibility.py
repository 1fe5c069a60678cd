"""Every view for everybody: axe finds nothing but minor issues, and all of it works by keyboard."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.async_api import Page, expect

from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from tests.browser.conftest import AXE, Service
from tests.browser.pages import VIEWS, open_page, press_briefly

pytestmark = pytest.mark.asyncio(loop_scope="session")

THEMES = ("dark", "light", "contrast")
CONTRAST = ("color-contrast",)


async def axe_issues(page: Page, *rules: str) -> list[str]:
    """Return what axe finds on the page as it is now, by all rules or by some, with the elements."""
    options = {"resultTypes": ["violations"], **({"runOnly": list(rules)} if rules else {})}
    result: dict[str, Any] = await page.evaluate("options => axe.run(options)", options)
    return [
        f"{violation['id']}: {node['html'][:160]} {node['failureSummary']}"
        for violation in result["violations"]
        if violation["impact"] in {"moderate", "serious", "critical"}
        for node in violation["nodes"]
    ]


async def test_axe_finds_no_issue_in_any_view_and_theme(axe_page: Page, service) -> None:
    page = axe_page
    await open_page(page, service.url)
    await page.add_script_tag(path=AXE)
    await service.mission.act(Action.START, None)
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    service.mission.notify(Severity.WARNING, "battery at 24 %", 2)
    await expect(page.get_by_test_id("alert-bar")).to_be_visible()
    for view in VIEWS:
        await page.get_by_test_id(f"view-{view}").click()
        await expect(page.get_by_test_id(f"view-{view}")).to_have_attribute("aria-current", "page")
        assert await axe_issues(page) == [], view
    finding = await service.mission.add_finding((18.0, 72.0, 0.0), "a jacket")
    service.mission.notify(Severity.NEWS, "Possible person")
    await page.goto(f"{service.url}#/decide?finding={finding.finding_id}")
    await page.get_by_test_id("way-change").click()
    assert await axe_issues(page) == [], "card of a finding"
    await page.get_by_test_id("send-on").click()
    assert await axe_issues(page) == [], "message about a finding"
    await page.keyboard.press("Escape")
    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("select-1").click()
    await expect(page.get_by_test_id("vehicle-panel")).to_be_visible()
    await page.get_by_test_id("fleet-view").click()
    await page.get_by_test_id("fleet-layout-tiles").click()
    assert await axe_issues(page) == [], "settings of the fleet"
    await page.keyboard.press("Escape")
    assert await axe_issues(page) == [], "tiles and a vehicle's panel"
    for theme in THEMES:
        await page.get_by_test_id("settings-open").click()
        await page.get_by_test_id(f"theme-{theme}").click()
        # Themes differ in their colours only: the other rules are applied once.
        assert await axe_issues(page, *(CONTRAST if theme != THEMES[0] else ())) == [], f"settings, {theme}"
        await page.get_by_test_id("settings-close").click()
        assert await axe_issues(page, *CONTRAST) == [], theme


async def test_axe_finds_no_issue_in_a_replay(axe_page: Page, replayed: str) -> None:
    await open_page(axe_page, replayed)
    await axe_page.add_script_tag(path=AXE)
    await axe_page.get_by_test_id("replay-event").last.focus()
    await expect(axe_page.get_by_test_id("replay-tip")).to_be_visible()
    assert await axe_issues(axe_page) == []


async def test_states_are_told_where_the_system_forces_its_colours(page: Page, service: Service) -> None:
    await page.emulate_media(forced_colors="active")
    await open_page(page, service.url)
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    await expect(page.get_by_test_id("alert-bar")).to_have_css("border-top-style", "solid")
    await page.get_by_test_id("select-1").click()
    dot = await page.get_by_test_id("connection").evaluate("dot => getComputedStyle(dot, '::before').backgroundColor")
    colours = [
        await page.locator(element).evaluate("element => getComputedStyle(element).backgroundColor")
        for element in (
            "main",
            "[data-testid=view-fly]",
            "[data-testid=view-plan]",
            "[data-testid=vehicle-1] .col-id",
            "[data-testid=vehicle-2] .col-id",
            "[data-testid=vehicle-1] .swatch",
        )
    ]
    canvas, current, other, selected, unselected, swatch = colours
    assert current == selected
    assert current not in {other, unselected, canvas}
    assert len({dot, swatch, canvas, current}) == len([dot, swatch, canvas, current])
    await page.emulate_media(forced_colors="none")


async def test_a_mission_is_launched_by_keyboard_alone(page: Page, service) -> None:
    await open_page(page, service.url)
    await page.keyboard.press("r")
    await page.get_by_test_id("check-1-link").focus()
    await page.keyboard.press("ArrowRight")
    await page.keyboard.press("ArrowDown")
    await expect(page.get_by_test_id("check-2-position")).to_be_focused()
    for _ in range(30):
        await page.keyboard.press("Tab")
        if await page.evaluate("document.activeElement.dataset.testid") == "launch":
            break
    await press_briefly(page, "launch")
    assert service.mission.actions == []
    await page.keyboard.down("Enter")
    await expect(page.get_by_test_id("phase")).not_to_have_text("Ready")
    await page.keyboard.up("Enter")
    assert service.mission.actions == [(Action.START, None)]
