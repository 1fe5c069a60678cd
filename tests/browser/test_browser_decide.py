"""Findings in a real browser: judged, marked by hand, printed."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest
import pytest_asyncio
from fastapi import FastAPI
from playwright.async_api import Page, Route, expect

from aos_gcs.geometry.notations import Notation
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.findings import FindingStatus, TargetEstimate
from aos_gcs.ports import Severity
from aos_gcs.runtime.recorded.viewer import Viewer
from tests.browser.conftest import OPERATOR_CODE, PageRecord, Service, serving
from tests.browser.pages import open_page, sign_in, with_thumbnails
from tests.fakes.app import app_of
from tests.fakes.handovers import ScriptedHandovers
from tests.fakes.mission import TARGET_ENU_M, ScriptedMission

pytestmark = pytest.mark.asyncio(loop_scope="session")

STEPS_UNTIL_FOUND = 20


@pytest_asyncio.fixture(loop_scope="session")
async def found_service(dashboard_build: None, tmp_path: Path) -> AsyncIterator[Service]:  # noqa: ARG001 - checks
    """A mission that has found something, for operators to judge."""

    def make_app(mission: ScriptedMission) -> FastAPI:
        viewer = Viewer(tmp_path, ImagingSettings(), focus_reach_m=5.0)  # of thumbnails, which the page shows then
        return app_of(mission, viewer=viewer, operator_code=OPERATOR_CODE)

    async with serving(make_app) as service:
        await service.mission.act(Action.START, None)
        for _ in range(STEPS_UNTIL_FOUND):
            service.mission.make_step()
        yield service


async def test_a_finding_is_confirmed_with_a_remark_and_seen_by_observers(
    page: Page, found_service: Service, page_record: PageRecord
) -> None:
    await with_thumbnails(page)
    await open_page(page, found_service.url, "decide")
    await page.get_by_test_id("finding-1").click()
    await expect(page.get_by_test_id("position-mgrs")).to_contain_text("33U VP")
    for command in ("judge-confirmed", "finding-save", "mark"):
        await expect(page.get_by_test_id(command)).to_have_count(0)

    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", code=OPERATOR_CODE)
    await page.get_by_test_id("judge-confirmed").click()
    await expect(page.get_by_test_id("finding-status")).to_have_text("✓ confirmed · Ada")
    await page.get_by_test_id("finding-comment").fill("lies under the spruce")
    await page.get_by_test_id("finding-assignee").fill("team 2")
    await page.get_by_test_id("finding-save").click()
    await expect(page.get_by_test_id("finding-1")).to_contain_text("team 2")
    (finding,) = found_service.mission.findings.all()
    assert finding.status is FindingStatus.CONFIRMED
    assert (finding.comment, finding.assignee, finding.operator) == ("lies under the spruce", "team 2", "Ada")

    await page.get_by_test_id("mark-at").click()
    await page.get_by_test_id("mark-place").fill("-91, 14.3")
    await expect(page.get_by_test_id("mark-place-problem")).to_contain_text("latitude and longitude, UTM")
    await expect(page.get_by_test_id("mark-ok")).to_be_disabled()
    await page.get_by_test_id("mark-place").fill("48.3 S 14.3 E")
    await page.get_by_test_id("mark-ok").click()
    await expect(page.get_by_test_id("mark-refusal")).to_contain_text("more than 50 km from the mission")
    page_record.errors.clear()  # the browser's word on the refusal

    await page.get_by_test_id("report-open").click()
    await page.emulate_media(media="print")
    await expect(page.get_by_test_id("report-finding-1")).to_contain_text("lies under the spruce")
    await expect(page.get_by_test_id("report-print")).to_be_hidden()
    await expect(page.get_by_test_id("connection")).to_be_hidden()
    assert page_record.errors == []


async def test_remarks_typed_while_the_station_answers_stay(page: Page, found_service: Service) -> None:
    await with_thumbnails(page)
    await open_page(page, found_service.url, "decide?finding=1")
    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", code=OPERATOR_CODE)
    comment = page.get_by_test_id("finding-comment")

    async def type_on(route: Route) -> None:
        await comment.fill("lies still, breathes")
        await route.continue_()

    await page.route("**/api/findings/1", type_on)
    await comment.fill("lies still")
    await page.get_by_test_id("finding-assignee").fill("team 2")
    await page.get_by_test_id("finding-save").click()
    await expect(page.get_by_test_id("finding-1")).to_contain_text("team 2")
    await expect(comment).to_have_value("lies still, breathes")
    await expect(page.get_by_test_id("finding-overtaken")).to_be_empty()
    await page.unroute("**/api/findings/1")

    await page.evaluate("""() => fetch("/api/findings/1", {
        method: "PATCH",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ comment: "moves" }),
    })""")
    await expect(page.get_by_test_id("finding-overtaken")).to_contain_text("moves")
    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("view-decide").click()
    await page.get_by_test_id("finding-1").click()
    await expect(comment).to_have_value("lies still, breathes")
    await page.get_by_test_id("finding-save").click()
    await expect(page.get_by_test_id("finding-overtaken")).to_be_empty()
    await expect(page.get_by_test_id("finding-save")).to_be_disabled()
    assert found_service.mission.findings.all()[0].comment == "lies still, breathes"


async def test_an_alert_leads_to_the_card_with_position_way_and_time(page: Page, found_service: Service) -> None:
    await with_thumbnails(page)
    await open_page(page, found_service.url)
    text = "Possible person (93 %) at 18.0 m east, 72.0 m north"
    found_service.mission.notify(Severity.NEWS, text, track_id=found_service.mission.findings.all()[0].track_id)
    await page.get_by_test_id("alert-bar").get_by_test_id("show-finding-1").click()

    card = page.get_by_test_id("finding-detail")
    await expect(card.get_by_test_id("position-decimal")).to_contain_text("48.33")
    await expect(card.get_by_test_id("way")).to_have_text(re.compile(r"\d{3}° true, 11\d\sm from the launch site"))
    await expect(card).to_contain_text(re.compile(r"First seen\d\d:\d\d:\d\d UTC"))
    await expect(page.get_by_test_id("alert-bar")).to_contain_text("48.33")

    for width_px, height_px in ((1280, 800), (390, 844)):
        await page.set_viewport_size({"width": width_px, "height": height_px})
        for picture in await card.locator("img").all():
            box = await picture.bounding_box()
            assert box is not None
            assert min(box["width"], box["height"]) > 100.0
    await page.get_by_test_id("plane-5").click()
    await page.get_by_test_id("cameras-nearest").click()
    shown = page.get_by_test_id("enlarge-thermal").locator("img")
    await expect(shown).to_have_attribute("src", re.compile("above_m=5&nearest=true"))

    await page.get_by_test_id("way-change").click()
    await page.get_by_test_id("reference-place").fill("33U VP 49890 53919")
    await expect(card.get_by_test_id("way")).to_contain_text("from the reference place")
    await page.get_by_test_id("send-on").click()
    await expect(page.get_by_test_id("message-text")).to_have_value(re.compile("from the reference place"))
    await page.keyboard.press("Escape")
    await page.reload()
    await expect(card.get_by_test_id("way")).to_contain_text("from the reference place")
    await page.get_by_test_id("way-change").click()
    await page.get_by_test_id("reference-launch").click()
    await expect(card.get_by_test_id("way")).to_contain_text("from the launch site")


async def test_pictures_of_a_finding_are_enlarged(page: Page, found_service: Service) -> None:
    await with_thumbnails(page)
    await open_page(page, found_service.url, "decide")
    await page.get_by_test_id("finding-1").click()
    await page.get_by_test_id("enlarge-thermal").focus()
    await page.keyboard.press("Enter")
    window = page.get_by_test_id("finding-large")
    await expect(window.locator("img")).to_have_count(2)
    for width_px, height_px, least_px in ((1280, 800, 500), (390, 844, 300)):
        await page.set_viewport_size({"width": width_px, "height": height_px})
        for picture in await window.locator("img").all():
            await expect(picture).to_be_visible()  # it has no box before its bytes are there
            box = await picture.bounding_box()
            assert box is not None
            assert min(box["width"], box["height"]) >= least_px
        assert await window.evaluate("window => window.scrollWidth <= window.clientWidth")
    await page.keyboard.press("Escape")
    await expect(window).to_have_count(0)
    await expect(page.get_by_test_id("enlarge-thermal")).to_be_focused()


async def test_a_finding_that_is_an_earlier_one_points_to_it(page: Page, found_service: Service) -> None:
    mission = found_service.mission
    (finding,) = mission.findings.all()
    assert finding.track_id is not None
    east_m, north_m, up_m = finding.position_enu_m
    for away_m in (4.0, 1.0):
        places = {finding.track_id: east_m, finding.track_id + 1: east_m + away_m}
        seen = [
            TargetEstimate((place_m, north_m, up_m), 0.1, 4, track_id, kind=finding.kind)
            for track_id, place_m in places.items()
        ]
        mission.findings.observe(seen, STEPS_UNTIL_FOUND, mission.elapsed_s)
        mission.findings.merge(seen)
    mission.make_step()
    await with_thumbnails(page)
    await page.goto(f"{found_service.url}#code={OPERATOR_CODE}")
    await sign_in(page, "Ada")
    await open_page(page, found_service.url, "decide")
    await page.get_by_test_id("finding-1").click()
    await expect(page.get_by_test_id("judge-confirmed")).to_be_visible()
    await page.get_by_test_id("finding-2").click()
    await expect(page.get_by_test_id("finding-status")).to_have_text("Same as finding 1")
    await expect(page.get_by_test_id("judge-confirmed")).to_have_count(0)
    await page.get_by_test_id("filter-open").click()
    await expect(page.get_by_test_id("finding-2")).to_have_count(0)


@pytest.mark.slow
async def test_a_place_is_marked_on_the_map_where_the_chosen_finding_is(map_page: Page, found_service: Service) -> None:
    page = map_page
    await with_thumbnails(page)
    await page.goto(f"{found_service.url}#code={OPERATOR_CODE}")
    await sign_in(page, "Ada")
    await open_page(page, found_service.url, "decide")
    await page.get_by_test_id("finding-1").click()
    await page.get_by_test_id("mark").click()
    await page.locator(".map-canvas canvas").click()  # its middle, where the chosen finding is shown
    await expect(page.get_by_test_id("finding-2")).to_have_attribute("aria-pressed", "true")
    marked = found_service.mission.findings.all()[1]
    assert marked.position_enu_m == pytest.approx(TARGET_ENU_M, abs=2.0)
    assert marked.operator == "Ada"


async def test_the_hand_over_is_downloaded_as_the_screen_writes_positions(
    page: Page,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
    page_record: PageRecord,
) -> None:
    handovers = ScriptedHandovers()
    async with serving(lambda mission: app_of(mission, handovers=handovers)) as service:
        await open_page(page, service.url, "decide")
        await page.evaluate("localStorage.setItem('aos-gcs-notation', 'mgrs')")
        await page.reload()
        async with page.expect_download() as downloading:
            await page.get_by_test_id("handover").click()
        download = await downloading.value
        assert download.suggested_filename == "handover-scripted-1.pdf"
        assert (await download.path()).read_bytes() == ScriptedHandovers.PDF
        assert handovers.asked[0].notation is Notation.MGRS
        async with page.expect_download() as downloading:
            await page.get_by_test_id("flights").click()
        assert (await downloading.value).suggested_filename == "flights.csv"
        await page.get_by_test_id("handover").click()
        await expect(page.get_by_test_id("handover-problem")).to_contain_text("being made already")
        page_record.errors.clear()  # the browser's word on the refusal


async def test_places_left_for_later_are_listed_with_the_targets(page: Page, found_service: Service) -> None:
    found_service.freeze()
    told = replace(found_service.mission.snapshot(), left_for_later=(LeftPlace((4.0, 20.0), 0.12),))
    found_service.mission.snapshot = lambda: told
    await open_page(page, found_service.url)
    later = page.get_by_test_id("left-for-later")
    await expect(later).to_contain_text("Left for a later look")
    await expect(later).to_contain_text("person: 12\N{NARROW NO-BREAK SPACE}%")
