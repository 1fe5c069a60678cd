"""What every screen must show truthfully: how old its data are, what was missed, and what others have done."""

from __future__ import annotations

import asyncio
from functools import partial
from pathlib import Path

import pytest
from playwright.async_api import Page, expect

from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.steps import FocusSnapshot, FocusSource
from aos_gcs.ports import Severity
from aos_gcs.runtime.recorded.viewer import Viewer
from tests.browser.conftest import OPERATOR_CODE, PageRecord, Service, serving
from tests.browser.pages import VIEWS, confirm, open_page, sign_in
from tests.fakes.app import app_of
from tests.fakes.viewed_step import record_viewed_step

pytestmark = pytest.mark.asyncio(loop_scope="session")


async def test_a_mission_that_hangs_is_never_shown_as_current(page: Page, service: Service) -> None:
    await open_page(page, service.url)
    await expect(page.locator(".page.is-old")).to_have_count(0)
    service.freeze()
    await expect(page.get_by_test_id("silent-banner")).to_contain_text("The mission does not respond")
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "silent")
    await expect(page.locator(".page.is-old")).to_have_count(1)
    # What comes from elsewhere, or to a page that is opened only now, makes it no younger.
    service.mission.notify(Severity.WARNING, "a driver lives longer than its mission")
    await page.reload()
    await expect(page.get_by_test_id("silent-banner")).to_be_visible()
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    service.fly()
    await expect(page.get_by_test_id("silent-banner")).to_have_count(0)
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")


async def test_an_alert_is_acknowledged_once_for_all_screens(
    page: Page, other_page: Page, guarded_service: Service
) -> None:
    service, observer = guarded_service, other_page
    for screen in (page, observer):
        await open_page(screen, service.url)
    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", code=OPERATOR_CODE)
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    for screen in (page, observer):
        await expect(screen.get_by_test_id("alert-bar")).to_contain_text("Vehicle 6: link lost")
    await expect(observer.get_by_test_id("alert-acknowledge")).to_have_count(0)

    await page.get_by_test_id("alert-acknowledge").click()
    for screen in (page, observer):
        await expect(screen.get_by_test_id("alert-bar")).to_have_count(0)
        await expect(screen.get_by_test_id("acknowledged")).to_contain_text("acknowledged by Ada")
    await observer.reload()
    await expect(observer.get_by_test_id("acknowledged")).to_contain_text("acknowledged by Ada")
    await expect(observer.get_by_test_id("alert-bar")).to_have_count(0)
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    await expect(observer.get_by_test_id("alert-bar")).to_be_visible()


async def test_a_page_that_was_away_for_too_long_says_what_it_has_missed(page: Page, service: Service) -> None:
    service.mission.notify(Severity.INFO, "the first one")
    await open_page(page, service.url)
    await expect(page.get_by_test_id("event")).to_have_count(1)
    await page.context.set_offline(True)
    await service.stop()
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "lost")
    await service.start()
    await asyncio.sleep(0)
    for number in range(210):  # ten more than are kept for those who come
        service.mission.notify(Severity.INFO, f"notice {number}")
        await asyncio.sleep(0)
    await page.context.set_offline(False)
    await expect(page.get_by_test_id("missed-banner")).to_contain_text("10 events were missed")
    await expect(page.get_by_test_id("events-missing")).to_contain_text("11 events not shown")  # the first one, too
    await page.get_by_test_id("missed-dismiss").click()
    await expect(page.get_by_test_id("missed-banner")).to_have_count(0)


async def test_no_view_asks_for_what_the_service_does_not_have(
    page: Page, service: Service, page_record: PageRecord
) -> None:
    """The simulation has no viewer, no plan and no findings to change; Chromium would log every refused request."""
    await service.mission.act(Action.START, None)
    for _ in range(20):
        service.mission.make_step()
    for view in VIEWS:
        await open_page(page, service.url, view)
        await expect(page.locator(f".view-{view}")).to_be_visible()
        await page.wait_for_load_state("networkidle")
    await open_page(page, service.url, "decide")
    await page.get_by_test_id("finding-1").click()
    await page.get_by_test_id("report-open").click()
    await page.wait_for_load_state("networkidle")
    assert page_record.errors == []


async def test_an_operator_changes_the_plane_of_the_mission(
    page: Page,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
    tmp_path: Path,
) -> None:
    viewer = Viewer(await record_viewed_step(tmp_path), ImagingSettings(), focus_reach_m=5.0)
    async with serving(partial(app_of, viewer=viewer, operator_code=OPERATOR_CODE)) as service:
        await service.mission.act(Action.START, None)
        service.mission.make_step()
        await open_page(page, service.url, "see?step=1")
        focus = page.get_by_test_id("mission-focus")
        await expect(focus).to_have_attribute("data-source", "configured")
        await expect(page.get_by_test_id("height")).to_be_visible()
        await expect(page.get_by_test_id("use-plane")).to_have_count(0)  # observers only see

        await page.get_by_test_id("sign-in-open").click()
        await sign_in(page, "Ada", code=OPERATOR_CODE)
        await page.get_by_test_id("height").fill("1.2")
        await page.get_by_test_id("use-plane").click()
        await expect(page.get_by_test_id("confirm")).to_contain_text("the whole mission")
        await confirm(page)
        await expect(page.get_by_test_id("results")).to_contain_text("Accepted")
        await expect(focus).to_contain_text("1.2")
        assert service.mission.focus == FocusSnapshot(1.2, FocusSource.OPERATOR, None)
        assert service.mission.operators[-1] == "Ada"

        await page.get_by_test_id("leave-plane").click()
        await confirm(page)
        await expect(focus).to_have_attribute("data-source", "configured")
