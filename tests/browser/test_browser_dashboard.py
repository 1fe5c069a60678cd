"""The dashboard in a real browser, against a scripted mission."""

from __future__ import annotations

import asyncio
import re
import socket

import pytest
from playwright.async_api import Page, Request, Route, expect

from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from tests.browser.conftest import OPERATOR_CODE, VIEWPORT_PX, WITHOUT_WEBGL, Service, serving
from tests.browser.map_colours import wait_until_drawn, wait_until_gone
from tests.browser.pages import (
    confirm,
    open_page,
    place_m,
    press_briefly,
    sign_in,
    start_mission,
    wait_for_visibility,
)
from tests.fakes.program import unused_port
from tests.fakes.scripted_vehicle import REFUSING_ID, SILENT_ID

pytestmark = pytest.mark.asyncio(loop_scope="session")

FIRST_LOAD_BYTES = (100_000, 450_000)
"""Least and most of what is sent until the page is shown; less than that has come from the browser's own files."""

REFUSED_STEP = 5
"""Step in which the scripted mission refuses a waypoint."""
VEHICLE_1_COLOUR, REFUSED_COLOUR = "#56b4e9", "#c40d1c"
"""Colours in the light theme."""
COMMANDS: dict[str, dict[str, object]] = {
    "/api/mission/actions": {"action": "start"},
    "/api/preflight/override": {"vehicle_id": SILENT_ID, "check": "camera", "reason": "none"},
    "/api/findings": {"position": {"latitude_deg": 48.3358, "longitude_deg": 14.3263}},
    "/api/plan/apply": {},
    "/api/notices/acknowledge": {"notice_ids": [1]},
}
"""Whatever an observer's browser may try behind the page's back."""
POST = """async ([path, body]) => {
    const answer = await fetch(path, {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
    return { status: answer.status, id: (await answer.json()).id };
}"""


async def test_page_shows_a_mission_without_errors_or_foreign_requests(map_page, service, page_record) -> None:
    await open_page(map_page, service.url)
    await expect(map_page.get_by_test_id("phase")).to_have_text("Ready")
    await expect(map_page.get_by_test_id(f"link-{SILENT_ID}")).to_have_text("no contact")
    await expect(map_page.get_by_test_id(f"height-{SILENT_ID}")).to_have_text("\N{EN DASH}")
    height = map_page.get_by_test_id("height-1")
    await expect(height).to_have_text("4.0\N{NARROW NO-BREAK SPACE}m AGL")
    await expect(height).to_have_attribute("title", re.compile("0.0.m above home, .* above sea level"))
    before = await place_m(map_page, 1)

    await start_mission(map_page)
    await map_page.keyboard.press("u")
    await wait_for_visibility(map_page, 0.3)
    await map_page.keyboard.press("f")
    await expect(map_page.locator(".map-canvas canvas")).to_be_visible()
    await expect(map_page.get_by_test_id("target-position")).to_contain_text("E ")
    assert await place_m(map_page, 1) != before
    assert page_record.errors == []
    assert page_record.foreign_requests == []


async def test_of_a_mission_of_hours_the_latest_steps_are_in_the_table(page: Page, service: Service) -> None:
    for _ in range(202):
        service.mission.make_step()
    await open_page(page, service.url, "understand")
    await page.get_by_test_id("form-table").click()
    table = page.get_by_test_id("step-table")
    # The mission makes steps meanwhile.
    await expect(table.locator("caption")).to_have_text(re.compile(r"^The latest 200 of \d{3} steps, newest first$"))
    await expect(table.locator("tbody tr")).to_have_count(200)
    oldest, newest = table.locator("tbody th").last, table.locator("tbody th").first
    await expect(oldest).not_to_have_text("1")
    assert int(await newest.inner_text()) >= 202


async def test_waypoints_are_drawn_on_the_map_and_hidden_with_their_layer(map_page, service) -> None:
    await service.mission.act(Action.START, None)
    for _ in range(REFUSED_STEP):
        service.mission.make_step()
    await service.mission.act(Action.HOLD, None)
    await open_page(map_page, service.url)
    await map_page.get_by_test_id("map-layers").click()
    for layer in ("vehicles", "trails", "footprints", "targets"):
        await map_page.get_by_test_id(f"layer-{layer}").uncheck()
    await map_page.get_by_test_id("map-layers").click()  # the list covers a part of the map
    for colour in (VEHICLE_1_COLOUR, REFUSED_COLOUR):
        await wait_until_drawn(map_page, colour)
    await map_page.get_by_test_id("map-layers").click()
    await map_page.get_by_test_id("layer-waypoints").uncheck()
    await map_page.get_by_test_id("map-layers").click()
    for colour in (VEHICLE_1_COLOUR, REFUSED_COLOUR):
        await wait_until_gone(map_page, colour)


async def test_what_has_been_searched_is_shown_with_its_legend_and_survives_a_reload(map_page, service) -> None:
    await open_page(map_page, service.url)
    await expect(map_page.get_by_test_id("searched")).to_have_count(0)
    await service.mission.act(Action.START, None)
    service.mission.make_step()
    await service.mission.act(Action.HOLD, None)  # vehicles that move have the map drawn again and again
    for is_opened_again in (False, True):
        if is_opened_again:
            await map_page.reload()
        panel = map_page.get_by_test_id("searched")
        for fact in ("63\N{NARROW NO-BREAK SPACE}%", "04:12", "51\N{NARROW NO-BREAK SPACE}%", "4.3"):
            await expect(panel).to_contain_text(fact)
        await expect(map_page.get_by_test_id("searched-legend")).to_contain_text("Probability of detection")
    await map_page.get_by_test_id("map-layers").click()
    await map_page.get_by_test_id("layer-searched").uncheck()
    await expect(map_page.get_by_test_id("searched-legend")).to_have_count(0)


async def test_segments_fit_their_panel_in_german(browser, service) -> None:
    await service.mission.act(Action.START, None)
    service.mission.make_step()
    context = await browser.new_context(locale="de", viewport=VIEWPORT_PX)
    page = await context.new_page()
    await page.add_init_script(WITHOUT_WEBGL)
    await open_page(page, service.url)
    await expect(page.get_by_test_id("segments").get_by_role("columnheader").first).to_have_text("Abschnitt")
    cut = """() => [...document.querySelectorAll('[data-testid=segments] :is(th, td)')]
        .filter((cell) => cell.scrollWidth > cell.clientWidth).map((cell) => cell.textContent)"""
    assert await page.evaluate(cut) == []
    panel = await page.get_by_test_id("searched").bounding_box()
    place = await page.get_by_test_id("segments").bounding_box()
    await context.close()
    assert panel is not None
    assert place is not None
    assert place["x"] + place["width"] <= panel["x"] + panel["width"]


async def test_the_map_stays_large_on_an_upright_tablet(page, service) -> None:
    await page.set_viewport_size({"width": 800, "height": 1280})
    await service.mission.act(Action.START, None)
    service.mission.make_step()
    await open_page(page, service.url)
    await expect(page.get_by_test_id("segments")).to_be_visible()
    place = await page.get_by_test_id("map").bounding_box()
    assert place is not None
    assert place["height"] >= 280


@pytest.mark.parametrize("width_px", [1280, 390])
async def test_segments_are_a_table_that_fits_and_says_what_is_not_known(page, service, width_px: int) -> None:
    await page.set_viewport_size({"width": width_px, "height": 844})
    await service.mission.act(Action.START, None)
    service.mission.make_step()
    await open_page(page, service.url)
    table = page.get_by_test_id("segments")
    await expect(table.get_by_role("columnheader")).to_have_text(["Segment", "Seen", "Detection, standing", "Success"])
    await expect(table.get_by_role("rowheader")).to_have_text(["A 1", "Ravine north of the old chapel"])
    percent, unknown = "\N{NARROW NO-BREAK SPACE}%", "no data"
    values = [f"70{percent}", f"55{percent}", f"33{percent}", f"12{percent}", unknown, unknown]
    await expect(table.get_by_role("cell")).to_have_text(values)
    panel = await page.get_by_test_id("searched").bounding_box()
    place = await table.bounding_box()
    assert panel is not None
    assert place is not None
    assert panel["x"] <= place["x"]
    assert place["x"] + place["width"] <= panel["x"] + panel["width"]


async def test_hold_never_asks_and_return_is_confirmed(page, service) -> None:
    await open_page(page, service.url)
    await start_mission(page)

    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("suspension")).to_have_text("Holding")
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")

    await page.get_by_test_id("action-return").click()
    await expect(page.get_by_test_id("confirm")).to_contain_text("Return all 8?")
    await press_briefly(page, "confirm-ok")
    await page.get_by_test_id("confirm-cancel").click()
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    assert [action for action, _ in service.mission.actions] == [Action.START, Action.HOLD]

    await page.get_by_test_id("action-return").click()
    await confirm(page)
    await expect(page.get_by_test_id("phase")).to_have_text("Returning")
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    await expect(page.get_by_test_id(f"result-{REFUSING_ID}")).to_have_attribute("data-accepted", "false")
    await expect(page.get_by_test_id(f"result-{REFUSING_ID}")).to_contain_text("refused by the autopilot")


async def test_selection_is_the_scope_and_the_key_holds_all(page, service) -> None:
    await open_page(page, service.url)
    await start_mission(page)
    await page.get_by_test_id("select-2").click()
    await page.get_by_test_id("vehicle-4").click(modifiers=["Shift"])
    await expect(page.get_by_test_id("scope")).to_have_text("3 of 8: 2, 3, 4")
    await page.keyboard.press("3")
    await expect(page.get_by_test_id("scope")).to_have_text("1 of 8: 3")
    await page.get_by_test_id("action-hold").click()
    await expect(page.get_by_test_id("result-3")).to_have_attribute("data-accepted", "true")
    await expect(page.get_by_test_id("task-3")).to_have_text("Holding")
    assert service.mission.actions[-1] == (Action.HOLD, (3,))

    await page.get_by_test_id("action-land").click()
    await page.keyboard.press("h")  # above an open question
    await expect(page.get_by_test_id("suspension")).to_have_text("Holding")
    await expect(page.get_by_test_id("confirm")).to_have_count(0)
    assert service.mission.actions[-1] == (Action.HOLD, None)


async def test_alerts_stay_until_they_are_acknowledged(page, service) -> None:
    await open_page(page, service.url, "plan")
    bar = page.get_by_test_id("alert-bar")
    await expect(page.get_by_test_id("connection")).to_have_text("Connected")
    assert await bar.count() == 0
    service.mission.notify(Severity.WARNING, "battery at 24 %", 2)
    await expect(bar).to_contain_text("Vehicle 2: battery at 24 %")
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    await expect(bar).to_have_attribute("data-severity", "critical")
    await page.get_by_test_id("alert-acknowledge").click()
    await expect(bar).to_have_attribute("data-severity", "warning")
    service.mission.notify(Severity.WARNING, "battery at 24 %", 4)
    await expect(bar).to_contain_text("2 vehicles (2, 4): battery at 24 %")
    await page.get_by_test_id("alert-acknowledge").click()
    await expect(bar).to_have_count(0)


async def test_a_failed_check_is_overridden_with_a_reason(page, service) -> None:
    await open_page(page, service.url, "prepare")
    cell = page.get_by_test_id(f"check-{SILENT_ID}-camera")
    await expect(cell).to_have_attribute("data-status", "fail")
    await cell.focus()
    await expect(page.get_by_test_id("check-remedy")).to_have_text("check its power and radio")
    await expect(page.get_by_test_id("override-ok")).to_be_disabled()
    await page.get_by_test_id("override-reason").fill("stays here as a spare")
    await page.get_by_test_id("override-ok").click()
    await expect(cell).to_have_attribute("data-status", "overridden")
    await expect(page.get_by_test_id("check-override")).to_have_text("stays here as a spare")


async def test_banner_says_disconnected_and_goes_when_the_service_is_back(page, service) -> None:
    await open_page(page, service.url)
    await service.stop()
    await expect(page.get_by_test_id("banner")).to_be_visible()
    await expect(page.get_by_test_id("action-hold")).to_be_disabled()
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("results-error")).to_contain_text("use the remote control")
    await service.start()
    await expect(page.get_by_test_id("banner")).to_have_count(0)
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")


async def test_without_webgl_a_sentence_stands_in_the_place_of_the_map(page, service) -> None:
    await open_page(page, service.url)
    await expect(page.get_by_test_id("map-message")).to_contain_text("WebGL")
    await expect(page.get_by_test_id("vehicle-1")).to_be_visible()


async def test_observers_see_the_same_and_cannot_command_until_they_sign_in(page, guarded_service, page_record) -> None:
    url = guarded_service.url
    await open_page(page, url)
    await expect(page.get_by_test_id("observer")).to_be_visible()
    await expect(page.get_by_test_id("vehicle-1")).to_be_visible()
    for command in ("hold-all", "action-hold", "action-start"):
        await expect(page.get_by_test_id(command)).to_have_count(0)
    await page.keyboard.press("h")
    await expect(page.get_by_test_id("results-error")).to_contain_text("Observers cannot send commands. Sign in")
    for path, body in COMMANDS.items():
        answer = await page.evaluate(POST, [path, body])
        assert answer == {"status": 403, "id": "operators_only"}, path
    assert guarded_service.mission.actions == []
    assert guarded_service.mission.overrides == {}
    assert guarded_service.mission.findings.all() == ()
    await expect(page.get_by_test_id("phase")).to_have_text("Ready")

    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", code="not-the-code")
    await expect(page.get_by_test_id("sign-in-refusal")).to_contain_text("Wrong operator code")
    page_record.errors.clear()  # the browser's word on the refusal
    await page.goto(f"{url}#code={OPERATOR_CODE}")
    await page.reload()
    await sign_in(page, "Ada")
    await start_mission(page)
    assert guarded_service.mission.operators == ["Ada"]
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    assert OPERATOR_CODE not in page.url
    await page.reload()
    await expect(page.get_by_test_id("hold-all")).to_be_visible()
    assert page_record.errors == []


async def test_a_sign_in_is_sent_although_the_role_arrives_while_its_button_is_pressed(page, guarded_service) -> None:
    role_asked, may_answer = asyncio.Event(), asyncio.Event()

    async def answer_late(route: Route) -> None:
        if route.request.method == "GET":
            role_asked.set()
            await may_answer.wait()
        await route.continue_()

    await page.route("**/api/session", answer_late)
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await page.get_by_test_id("sign-in-name").fill("Ada")
    await page.get_by_test_id("sign-in-ok").hover()
    await role_asked.wait()
    await page.mouse.down()
    may_answer.set()
    await expect(page.get_by_test_id("observer")).to_be_attached()
    await page.mouse.up()
    await expect(page.get_by_test_id("operator")).to_have_text("Ada")


async def test_an_operator_can_command_although_answers_of_the_station_are_lost(page, guarded_service) -> None:
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await sign_in(page, "Ada")
    await page.get_by_test_id("view-fly").click()
    await expect(page.get_by_test_id("action-hold")).to_be_visible()
    asked, has_commanded = 0, False

    async def lose(route: Route) -> None:
        nonlocal asked
        asked += 1
        if asked == 1:
            return  # no answer at all
        await (route.continue_() if has_commanded else route.abort())

    await page.route("**/api/session", lose)
    await page.reload()
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    await expect(page.get_by_test_id("action-hold")).to_be_visible()
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
    async with page.expect_response("**/api/session"):
        has_commanded = True  # commands wait for no answer
    await expect(page.get_by_test_id("sign-in-open")).to_have_count(0)


async def test_a_hundred_vehicles_are_seen_at_a_glance_the_worst_first(page: Page, dashboard_build: None) -> None:  # noqa: ARG001 - a check
    # At an address of which the browser keeps no files.
    async with serving(vehicles=100, port=unused_port(socket.SOCK_STREAM)) as service:
        await page.set_viewport_size({"width": 1920, "height": 1080})
        requests: list[Request] = []

        def note(request: Request) -> None:
            requests.append(request)

        page.on("requestfinished", note)
        await open_page(page, service.url)
        tiles = page.get_by_test_id("vehicles").locator("button[data-testid^=vehicle-]")
        await expect(tiles).to_have_count(100)
        for tile in (tiles.first, tiles.last):
            await expect(tile).to_be_in_viewport(ratio=1)
        await expect(tiles.first).to_have_attribute("data-level", "critical")
        service.freeze()
        page.remove_listener("requestfinished", note)
        sent = [await request.sizes() for request in requests]
        least, most = FIRST_LOAD_BYTES
        assert least <= sum(one["responseBodySize"] + one["responseHeadersSize"] for one in sent) <= most

        await page.get_by_test_id("fleet-filter-attention").click()
        await expect(tiles.last).to_have_attribute("data-level", re.compile("warning|critical"))
        await page.get_by_test_id("fleet-filter-all").click()
        for vehicle_id in range(1, 13):
            service.mission.notify(Severity.WARNING, "no GPS fix", vehicle_id)
        await expect(page.get_by_test_id("alert-bar")).to_contain_text("12 vehicles (1–12): no GPS fix")  # noqa: RUF001

        await page.get_by_test_id("vehicle-3").click()
        panel = page.get_by_test_id("vehicle-panel")
        await expect(panel).to_contain_text("Vehicle 3")
        await expect(panel.locator("figure")).to_have_count(3)
        await page.get_by_test_id("fleet-view").click()
        await page.get_by_test_id("fleet-layout-table").click()
        await page.get_by_test_id("fleet-column-gps").click()
        await page.keyboard.press("Escape")
        await page.reload()
        await expect(page.locator(".fleet thead")).to_contain_text("Link")
        await expect(page.locator(".fleet thead")).not_to_contain_text("GPS")


async def test_who_is_signed_in_is_shown_and_heights_in_the_chosen_units(page: Page, guarded_service: Service) -> None:
    await guarded_service.mission.act(Action.START, None)
    await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
    await sign_in(page, "Robin")
    await expect(page.get_by_test_id("operator")).to_have_text("Robin")
    await expect(page.get_by_test_id("height-1")).to_contain_text("m AGL")
    await page.get_by_test_id("settings-open").click()
    await page.get_by_test_id("units-imperial").click()
    await page.get_by_test_id("settings-close").click()
    await expect(page.get_by_test_id("height-1")).to_contain_text("ft AGL")
