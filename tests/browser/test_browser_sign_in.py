"""Signing in by the operators' address: a name is all that is missing, and leaving its field is enough."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Page, Request, Route, expect

from aos_gcs.mission.model.actions import Action
from tests.browser.conftest import AXE, OPERATOR_CODE, Service
from tests.browser.pages import hold
from tests.browser.test_browser_accessibility import axe_issues

pytestmark = pytest.mark.asyncio(loop_scope="session")

STARTED = (Action.START, None)
LONGER_THAN_A_PRESS_MS = 1200


@pytest_asyncio.fixture(loop_scope="session")
async def opened(page: Page, guarded_service: Service) -> AsyncIterator[Page]:
    """The operators' address on a screen that knows no name."""
    await open_address(page, guarded_service)
    yield page


async def open_address(page: Page, service: Service, code: str = OPERATOR_CODE) -> None:
    await page.goto(f"{service.url}#code={code}")
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    await expect(page.get_by_test_id("observer")).to_be_visible()
    await expect(page.get_by_test_id("sign-in-name")).to_be_focused()


async def test_a_typed_name_and_one_held_press_launch(opened: Page, guarded_service: Service) -> None:
    launch = opened.get_by_test_id("launch")
    await expect(launch).to_be_disabled()
    await expect(opened.get_by_test_id("launch-consequence")).to_contain_text("Sign in at the top")
    before = await launch.bounding_box()
    await opened.get_by_test_id("sign-in-name").fill(" Ada ")
    await expect(opened.get_by_test_id("launch-consequence")).to_contain_text("Recorded as Ada.")
    await launch.hover()
    await opened.mouse.down()
    await expect(opened.get_by_test_id("operator")).to_have_text("Ada")
    assert await launch.bounding_box() == before, "signing in moves nothing from under the pointer"
    await expect(opened.get_by_test_id("phase")).not_to_have_text("Ready")
    await opened.mouse.up()
    assert guarded_service.mission.actions == [STARTED]
    assert guarded_service.mission.operators == ["Ada"]


async def test_a_name_and_enter_lead_to_the_launch_by_keyboard(opened: Page, guarded_service: Service) -> None:
    await opened.keyboard.type("Ada")
    await opened.keyboard.press("Enter", delay=LONGER_THAN_A_PRESS_MS)
    await expect(opened.get_by_test_id("operator")).to_have_text("Ada")
    await expect(opened.get_by_role("group", name="Launch")).to_be_focused()
    assert guarded_service.mission.actions == [], "the key that has signed in launches nothing"
    await expect(opened.get_by_test_id("launch")).to_be_enabled()
    await opened.keyboard.press("Tab")
    await expect(opened.get_by_test_id("launch")).to_be_focused()
    await opened.keyboard.down("Enter")
    await expect(opened.get_by_test_id("phase")).not_to_have_text("Ready")
    await opened.keyboard.up("Enter")
    assert guarded_service.mission.operators == ["Ada"]


async def test_a_press_signs_in_but_launches_nothing_before_the_station_has_the_name(
    opened: Page, guarded_service: Service
) -> None:
    may_answer = asyncio.Event()

    async def answer_late(route: Route) -> None:
        await may_answer.wait()
        await route.continue_()

    await opened.route("**/api/session", answer_late)
    await opened.get_by_test_id("sign-in-name").fill("Ada")
    await opened.get_by_test_id("launch").hover()
    await opened.mouse.down()
    await expect(opened.get_by_test_id("launch-note")).to_contain_text("Not launched")
    await opened.mouse.up()
    may_answer.set()
    await expect(opened.get_by_test_id("operator")).to_have_text("Ada")
    await expect(opened.get_by_test_id("launch-note")).to_be_empty()
    assert guarded_service.mission.actions == []
    await hold(opened, "launch", expect(opened.get_by_test_id("phase")).not_to_have_text("Ready"))
    assert guarded_service.mission.operators == ["Ada"]


async def test_nobody_is_signed_in_by_an_empty_field_or_while_still_typing(opened: Page) -> None:
    sent: list[str] = []

    def note(request: Request) -> None:
        if request.method == "POST":
            sent.append(request.url)

    opened.on("request", note)
    name = opened.get_by_test_id("sign-in-name")
    await opened.get_by_test_id("preflight").click()
    await expect(name).not_to_be_focused()
    await name.fill("  ")
    await name.press("Enter")
    await expect(opened.get_by_test_id("name-refusal")).to_have_text("Enter your name: the audit log needs it.")
    await name.fill("Ad")
    await expect(opened.get_by_test_id("name-refusal")).to_be_empty()
    # Another window has come to the front: the field keeps the focus within the page.
    await name.evaluate("field => field.dispatchEvent(new FocusEvent('focusout', { bubbles: true }))")
    await opened.keyboard.press("Tab")
    await expect(opened.get_by_test_id("sign-in-ok")).to_be_focused()
    await expect(opened.get_by_test_id("observer")).to_be_visible()
    opened.remove_listener("request", note)
    assert sent == []


async def test_a_wrong_code_is_told_beside_the_name_and_can_be_typed_anew(page: Page, guarded_service: Service) -> None:
    await open_address(page, guarded_service, "wrong-code")
    await page.get_by_test_id("sign-in-name").fill("Ada")
    await page.get_by_test_id("launch").hover()
    await page.mouse.down()
    await expect(page.get_by_test_id("name-refusal")).to_contain_text("Wrong operator code")
    await expect(page.get_by_test_id("launch")).to_be_disabled()
    await page.mouse.up()
    assert guarded_service.mission.actions == []
    await page.get_by_test_id("other-code").click()
    await expect(page.get_by_test_id("name-field")).to_have_count(0)
    await expect(page.get_by_test_id("sign-in-name")).to_have_value("Ada")
    await page.get_by_test_id("sign-in-code").fill(OPERATOR_CODE)
    await page.get_by_test_id("sign-in-ok").click()
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")
    await hold(page, "launch", expect(page.get_by_test_id("phase")).not_to_have_text("Ready"))
    assert guarded_service.mission.operators == ["Ada"]


@pytest.mark.parametrize("width_px", [1280, 800, 390])
async def test_the_field_fits_the_header_and_readers_of_the_screen(
    axe_page: Page, guarded_service: Service, width_px: int
) -> None:
    page = axe_page
    await page.set_viewport_size({"width": width_px, "height": 844})
    await open_address(page, guarded_service, "wrong-code")
    await page.add_script_tag(path=AXE)
    await page.keyboard.type("Katharina Bergmoser")
    await page.keyboard.press("Enter")
    await expect(page.get_by_test_id("name-refusal")).to_be_visible()
    assert await axe_issues(page) == []
    assert await page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
    field = await page.get_by_test_id("name-field").bounding_box()
    refusal = await page.get_by_test_id("name-refusal").bounding_box()
    assert field is not None
    assert refusal is not None
    assert field["x"] >= 0
    assert field["x"] + field["width"] <= width_px
    assert 0 < refusal["y"] - (field["y"] + field["height"]) < 40, "beside the field"
