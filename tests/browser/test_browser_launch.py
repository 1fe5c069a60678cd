"""The launch from the view Prepare: one held press, which names the vehicles, and confirms them where nobody has."""

from __future__ import annotations

import re

import pytest
from playwright.async_api import Page, expect

from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from tests.browser.conftest import OPERATOR_CODE, Service
from tests.browser.pages import hold, open_page, sign_in, wait_for

pytestmark = pytest.mark.asyncio(loop_scope="session")

CHOSEN, STARTED = (Action.CHOOSE, (1, 2, 3)), (Action.START, None)
STEPS_UNTIL_FOUND = 20
COME_ANEW = """card => {
    card.style.animation = "none";
    card.getBoundingClientRect();  // takes the animation away
    card.style.animation = "";
    return getComputedStyle(card).pointerEvents;
}"""
"""Begins the animation of a card again, which may be over by now; returns what it lets through then."""


async def press(page: Page) -> None:
    """Press the button until it has confirmed the vehicles, and keep it pressed."""
    await expect(page.get_by_test_id("launch")).to_have_text("Hold to confirm and launch 1\N{EN DASH}3")
    await page.get_by_test_id("launch").hover()
    await page.mouse.down()
    await expect(page.get_by_test_id("vehicles-confirmed")).to_contain_text("Confirmed: 1\N{EN DASH}3")


async def test_one_held_press_confirms_the_vehicles_and_launches_them(page: Page, service: Service) -> None:
    service.mission.forget_vehicles()
    await open_page(page, service.url, "prepare")
    await expect(page.get_by_test_id("launch-consequence")).to_contain_text("The motors start")
    await expect(page.get_by_test_id("preflight-problems")).to_have_text("Confirm the vehicles")
    await press(page)
    await expect(page.get_by_test_id("launch")).to_contain_text("Keep holding")
    assert service.mission.actions == [CHOSEN]
    service.mission.pass_preflight()
    await expect(page.get_by_test_id("view-fly")).to_have_attribute("aria-current", "page")
    await page.mouse.up()
    assert service.mission.actions == [CHOSEN, STARTED]


async def test_who_lets_go_before_the_checks_have_passed_launches_nothing(page: Page, service: Service) -> None:
    service.mission.forget_vehicles()
    await open_page(page, service.url, "prepare")
    await press(page)
    await page.mouse.up()
    await expect(page.get_by_test_id("launch")).to_be_disabled()
    service.mission.pass_preflight()
    await expect(page.get_by_test_id("launch")).to_have_text("Hold to launch 1\N{EN DASH}3")
    assert service.mission.actions == [CHOSEN]


async def test_a_warning_that_nobody_could_read_before_ends_the_press(page: Page, service: Service) -> None:
    service.mission.forget_vehicles()
    await open_page(page, service.url, "prepare")
    await press(page)
    service.mission.pass_preflight(warning="through the layers of others")
    await expect(page.get_by_test_id("launch-note")).to_contain_text("read the new warnings")
    await page.mouse.up()
    assert service.mission.actions == [CHOSEN]
    await hold(page, "launch", expect(page.get_by_test_id("phase")).not_to_have_text("Ready"))
    assert service.mission.actions == [CHOSEN, STARTED]


async def test_another_number_of_vehicles_than_planned_is_confirmed_by_itself(page: Page, service: Service) -> None:
    service.mission.forget_vehicles()
    await open_page(page, service.url, "prepare")
    await page.get_by_test_id("choose-3").uncheck()
    await expect(page.get_by_test_id("launch")).to_be_disabled()
    await page.get_by_test_id("confirm-vehicles").click()
    await expect(page.get_by_test_id("vehicles-confirmed")).to_contain_text("Confirmed: 1\N{EN DASH}2")
    assert service.mission.actions == [(Action.CHOOSE, (1, 2))]


async def test_whose_name_the_browser_knows_opens_the_address_and_launches_by_two_keys(
    page: Page, guarded_service: Service
) -> None:
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await sign_in(page, "Ada")
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")
    await page.context.clear_cookies()
    await page.goto("about:blank")
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")
    await expect(page.get_by_test_id("view-prepare")).to_have_attribute("aria-current", "page")
    await expect(page.get_by_test_id("launch-consequence")).to_contain_text("Recorded as Ada")
    await expect(page.get_by_role("group", name="Launch")).to_be_focused()
    await expect(page.get_by_test_id("launch")).to_be_enabled()
    await page.keyboard.press("Tab")
    await expect(page.get_by_test_id("launch")).to_be_focused()
    await page.keyboard.down("Enter")
    await expect(page.get_by_test_id("phase")).not_to_have_text("Ready")
    await page.keyboard.up("Enter")
    assert guarded_service.mission.actions == [STARTED]
    assert guarded_service.mission.operators == ["Ada"]


async def test_somebody_else_at_a_screen_that_knows_a_name_needs_neither_the_code_nor_a_sign_out(
    page: Page, guarded_service: Service
) -> None:
    await open_page(page, guarded_service.url)
    await expect(page.get_by_test_id("not-me")).to_have_count(0)
    await page.evaluate("() => localStorage.setItem('aos-gcs-operator', 'Ada')")
    await page.goto("about:blank")
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")
    await page.get_by_test_id("not-me").click()
    await expect(page.get_by_test_id("sign-in-until")).to_contain_text("Ada stays signed in")
    await expect(page.get_by_test_id("dialog-hold-all")).to_be_visible()
    await page.keyboard.press("Escape")  # pressed by mistake
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")
    await page.get_by_test_id("not-me").click()
    await expect(page.get_by_test_id("sign-in-name")).to_have_value("")
    await sign_in(page, "Ben")
    await expect(page.get_by_test_id("operator")).to_have_text("Ben")
    await expect(page.get_by_test_id("launch-consequence")).to_contain_text("Recorded as Ben")
    await page.get_by_test_id("not-me").click()
    await page.get_by_test_id("sign-in-cancel").click()
    await expect(page.get_by_test_id("observer")).to_be_visible()


async def test_a_known_name_with_a_wrong_code_is_asked_for_the_code(page: Page, guarded_service: Service) -> None:
    await open_page(page, guarded_service.url)
    await page.evaluate("() => localStorage.setItem('aos-gcs-operator', 'Ada')")
    await page.goto("about:blank")
    await page.goto(f"{guarded_service.url}#code=wrong-code")
    await expect(page.get_by_test_id("sign-in")).to_be_visible()
    await expect(page.get_by_test_id("observer")).to_be_visible()


@pytest.mark.parametrize("width_px", [1280, 390])
async def test_a_possible_person_is_confirmed_on_the_map_by_one_press(
    page: Page, service: Service, width_px: int
) -> None:
    await page.set_viewport_size({"width": width_px, "height": 844})
    await service.mission.act(Action.START, None)
    for _ in range(STEPS_UNTIL_FOUND):
        service.mission.make_step()
    (finding,) = service.mission.findings.all()
    await open_page(page, service.url)
    await expect(page.get_by_test_id("alerted-finding")).to_have_count(0)
    service.mission.notify(Severity.NEWS, "Possible person", track_id=finding.track_id)
    card = page.get_by_test_id("alerted-finding")
    await expect(card).to_be_visible()
    place, map_place = await card.bounding_box(), await page.get_by_test_id("map").bounding_box()
    assert place is not None
    assert map_place is not None
    assert place["x"] >= 0
    assert place["x"] + place["width"] <= width_px
    held = await page.get_by_test_id("hold-all").bounding_box()
    assert held is not None
    assert held["y"] + held["height"] <= place["y"]
    if width_px > 1000:
        picture = await card.get_by_role("link").first.bounding_box()
        assert picture is not None
        assert picture["width"] >= 200
        covered_px2 = (map_place["y"] + map_place["height"] - place["y"]) * place["width"]
        assert covered_px2 < 0.15 * map_place["width"] * map_place["height"], "the place is seen on the map"
    await card.get_by_test_id("judge-confirmed").click()
    await expect(card.get_by_test_id("alerted-status")).to_have_text(re.compile("confirmed"))
    await card.get_by_test_id("alerted-close").click()
    await expect(card).to_have_count(0)


async def test_a_card_that_has_just_come_takes_no_press_meant_for_the_map(page: Page, service: Service) -> None:
    await service.mission.act(Action.START, None)
    for _ in range(STEPS_UNTIL_FOUND):
        service.mission.make_step()
    (finding,) = service.mission.findings.all()
    service.mission.notify(Severity.NEWS, "Possible person", track_id=finding.track_id)
    await open_page(page, service.url)
    card = page.get_by_test_id("alerted-finding")
    await expect(card).to_be_visible()
    assert await card.evaluate(COME_ANEW) == "none"
    await wait_for(page, "() => getComputedStyle(document.querySelector('.alerted-finding')).pointerEvents === 'auto'")
