"""Commands that are pressed into a network that stalls, as an operator sees them."""

from __future__ import annotations

import asyncio

import pytest
from playwright.async_api import expect

from aos_gcs.mission.command_order import CommandOrder
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase, Suspension
from tests.browser.pages import confirm, open_page, start_mission
from tests.fakes.stalling_link import stalling_link

pytestmark = pytest.mark.asyncio(loop_scope="session")


async def test_a_launch_pressed_into_a_stall_arms_no_vehicle_when_the_link_is_back(page, service) -> None:
    service.mission.order = CommandOrder("scripted-1", asyncio.get_running_loop().time)
    async with stalling_link(service.url) as link:
        await open_page(page, link.url)
        await page.get_by_test_id("action-start").click()
        link.stall(down=False)
        await confirm(page)
        unconfirmed = page.get_by_test_id("results-unconfirmed")
        await expect(unconfirmed).to_have_text("Not confirmed: use the remote control")
        link.stall()
        await expect(page.get_by_test_id("banner")).to_be_visible()
        await page.get_by_test_id("hold-all").click()
        await expect(unconfirmed).to_have_count(2)
        assert service.mission.actions == []

        link.go_on()
        await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
        await expect(page.get_by_test_id("results-error")).to_contain_text("Not done: the command arrived with data")
        await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
        assert service.mission.actions == [(Action.HOLD, None)], "a hold is worth sending at any time"
        assert service.mission.phase is Phase.READY


async def test_a_question_answered_without_connection_sends_nothing(page, service) -> None:
    async with stalling_link(service.url) as link:
        await open_page(page, link.url)
        await page.get_by_test_id("action-start").click()
        link.stall()
        await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "lost")
        await confirm(page)
        await expect(page.get_by_test_id("results-error")).to_contain_text("Not sent: no connection")
        link.go_on()
        await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
        await page.get_by_test_id("hold-all").click()
        await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
        assert service.mission.actions == [(Action.HOLD, None)]


async def test_an_old_resume_does_not_undo_the_hold_of_another_operator(page, service) -> None:
    async with stalling_link(service.url) as link:
        await open_page(page, link.url)
        await start_mission(page)
        await page.get_by_test_id("hold-all").click()
        await expect(page.get_by_test_id("suspension")).to_have_text("Holding")
        link.stall(down=False)
        await page.get_by_test_id("action-resume").click()
        await service.mission.act(Action.HOLD, None, operator="Robin")
        link.go_on()
        await expect(page.get_by_test_id("results-error")).to_contain_text("Robin sent hold meanwhile")
        assert service.mission.suspension is Suspension.HELD

        await expect(page.get_by_test_id("event").filter(has_text="Operator: hold")).to_have_count(2)
        await page.get_by_test_id("action-resume").click()
        await expect(page.get_by_test_id("suspension")).to_have_count(0)
