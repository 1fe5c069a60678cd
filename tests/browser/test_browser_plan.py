"""Planning in a real browser: drawn on the map, by numbers, from files; checked, saved, applied."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
import pytest_asyncio
from fastapi import FastAPI
from playwright.async_api import FilePayload, Page, Route, expect

from aos_gcs.geometry.notations import dms, mgrs_text
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.shape_files import MAX_FILE_BYTES
from tests.browser.conftest import OPERATOR_CODE, PageRecord, Service, serving
from tests.browser.pages import confirm, hold, open_page
from tests.fakes.app import app_of
from tests.fakes.mission import ORIGIN, ScriptedMission

pytestmark = pytest.mark.asyncio(loop_scope="session")

CORNERS_PX = ((-60, -60), (60, -60), (60, 40), (-60, 40))
"""Corners relative to the middle of the map; y is down."""


async def on_map(page: Page, from_middle_px: tuple[int, int]) -> tuple[float, float]:
    """Return where a pixel of the map is on the page."""
    box = await page.locator(".map-canvas canvas").bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2 + from_middle_px[0], box["y"] + box["height"] / 2 + from_middle_px[1]


@asynccontextmanager
async def planning(plans_folder: Path, operator_code: str | None = None) -> AsyncIterator[Service]:
    """A mission that can be planned."""

    def make_app(mission: ScriptedMission) -> FastAPI:
        return app_of(mission, plans_folder=plans_folder, operator_code=operator_code)

    async with serving(make_app) as service:
        yield service


@pytest_asyncio.fixture(loop_scope="session")
async def planned_service(tmp_path: Path, dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - its check
    """One that everybody may plan."""
    async with planning(tmp_path / "plans") as service:
        yield service


@pytest_asyncio.fixture(loop_scope="session")
async def guarded_plan(tmp_path: Path, dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - its check
    """One that only operators may plan."""
    async with planning(tmp_path / "plans", OPERATOR_CODE) as service:
        yield service


async def open_plan(page: Page, service: Service) -> None:
    await open_page(page, service.url, "plan")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")


def square(half_deg: float) -> list[list[float]]:
    """A closed ring about the origin, longitude first."""
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
    return [[ORIGIN.longitude_deg + east * half_deg, ORIGIN.latitude_deg + north * half_deg] for east, north in signs]


def geojson() -> bytes:
    return json.dumps({"type": "Polygon", "coordinates": [square(1e-3)]}).encode()


def kml() -> bytes:
    ring = " ".join(f"{east},{north},0" for east, north in square(2e-4))
    boundary = f"<outerBoundaryIs><LinearRing><coordinates>{ring}</coordinates></LinearRing></outerBoundaryIs>"
    placemark = f"<Placemark><name>No-go pond</name><Polygon>{boundary}</Polygon></Placemark>"
    return f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{placemark}</Document></kml>'.encode()


def qgc_plan() -> bytes:
    home = [ORIGIN.latitude_deg, ORIGIN.longitude_deg, 0.0]
    return json.dumps({"fileType": "Plan", "mission": {"items": [], "plannedHomePosition": home}}).encode()


async def test_a_no_go_zone_is_drawn_and_refused_beside_it_while_it_crosses_itself(
    map_page: Page, planned_service: Service, page_record: PageRecord
) -> None:
    page = map_page
    await open_plan(page, planned_service)
    await page.get_by_test_id("add-no-go").click()
    canvas = page.locator(".map-canvas canvas")
    await expect(canvas).to_have_css("cursor", "crosshair")
    await expect(page.get_by_test_id("plan-blocked")).to_be_visible()
    place_without_profile = await canvas.bounding_box()
    for number, corner_px in enumerate(CORNERS_PX, 1):
        await page.mouse.click(*await on_map(page, corner_px))
        await expect(page.get_by_test_id("shape-no_go[0]")).to_contain_text(f"{number} corner")
    await page.get_by_test_id("draw").click()
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    assert await canvas.bounding_box() == place_without_profile, "the map stays where it is while somebody draws"

    await page.mouse.move(*await on_map(page, CORNERS_PX[0]))
    await page.mouse.down()
    await page.mouse.move(*await on_map(page, (100, -20)), steps=3)
    await page.mouse.up()
    await expect(page.get_by_test_id("shape-problem-no_go[0]")).to_contain_text("must not cross")
    await expect(page.get_by_test_id("plan-apply")).to_be_disabled()
    await page.get_by_test_id("draw-remove").click()
    await expect(page.get_by_test_id("shape-no_go[0]")).to_contain_text("3 corners")
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    assert page_record.errors == []


async def test_a_plan_that_is_read_while_the_mission_gets_it_is_the_current_one(
    page: Page, planned_service: Service
) -> None:
    await open_plan(page, planned_service)
    await page.get_by_test_id("plan-layer_spacing_m").fill("4")
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()

    async def answer_after_the_news(route: Route) -> None:
        response = await route.fetch()
        await expect(page.get_by_test_id("plan-reload")).to_be_visible()
        await route.fulfill(response=response)

    await page.route("**/api/plan", answer_after_the_news)
    await page.get_by_test_id("plan-apply").click()
    await expect(page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")
    await expect(page.get_by_test_id("plan-reload")).to_have_count(0)


async def test_a_plan_made_by_numbers_is_saved_and_applied_before_the_start(
    page: Page, planned_service: Service
) -> None:
    await open_plan(page, planned_service)
    await page.get_by_test_id("vertex-remove-3").click()
    await page.get_by_test_id("vertex-2-0").fill("70")
    await page.get_by_test_id("plan-layer_spacing_m").fill("0")
    await expect(page.get_by_test_id("plan-layer_spacing_m-problem")).to_have_text("Enter 0.1 or more")
    await page.get_by_test_id("plan-layer_spacing_m").fill("0.5")
    await expect(page.get_by_test_id("plan-layer_spacing_m-problem")).to_contain_text("too close")
    await page.get_by_test_id("plan-show-problem").click()
    await expect(page.get_by_test_id("plan-layer_spacing_m")).to_be_focused()
    await page.get_by_test_id("plan-layer_spacing_m").fill("4")
    await page.get_by_test_id("plan-dial").press("ArrowRight")
    await page.get_by_test_id("plan-name").fill("north slope")
    await page.get_by_test_id("plan-save").click()
    await expect(page.get_by_test_id("saved-north slope")).to_be_visible()
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    await page.get_by_test_id("plan-apply").click()
    await expect(page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")
    applied = plan_of(planned_service.mission.settings)
    assert applied.layer_spacing_m == 4.0
    assert applied.area_enu_m[2] == pytest.approx((70.0, 110.0), abs=0.1)
    assert len(applied.area_enu_m) == 3

    await expect(page.get_by_test_id("plan-reload")).to_have_count(0)
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    await hold(page, "delete-north slope", expect(page.get_by_test_id("saved-north slope")).to_have_count(0))
    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("action-start").click()
    await confirm(page)
    await page.get_by_test_id("view-plan").click()
    await expect(page.get_by_test_id("plan-late")).to_be_visible()
    await expect(page.get_by_test_id("plan-apply")).to_be_disabled()


async def test_a_swarm_is_split_where_it_searches_in_flight(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    split = page.get_by_test_id("plan-split")
    await page.get_by_test_id("plan-search_mode").set_checked(False)
    await expect(split).to_have_count(0)
    await page.get_by_test_id("plan-search_mode").set_checked(True)
    await expect(split).not_to_be_checked()
    await split.check()
    await page.locator("#plan-vehicles").fill("7")
    await expect(page.locator("#plan-split-advice")).to_contain_text("It takes 8 vehicles")
    await page.locator("#plan-vehicles").fill("8")
    await expect(page.locator("#plan-split-advice")).to_be_empty()
    await page.get_by_test_id("plan-apply").click()
    await expect(page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")
    assert plan_of(planned_service.mission.settings).split


async def test_the_profile_shows_the_chosen_leg_and_follows_the_plan(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    summary = page.get_by_test_id("profile-summary")
    await expect(summary).to_contain_text("Lowest layer at least 35.0")
    leg = page.get_by_test_id("profile-leg")
    count = await leg.locator("option").count()
    assert count > 1
    await leg.select_option(str(count - 1))
    await page.locator("#plan-lowest_layer_m").fill("41")
    await expect(summary).to_contain_text("Lowest layer at least 41.0")
    await expect(leg).to_have_value(str(count - 1))
    await page.get_by_test_id("profile-numbers").click()
    await expect(page.get_by_role("cell", name="36 m").first).to_be_visible()  # the floor, 5 m below


async def test_shapes_come_from_files_and_broken_ones_are_refused(
    page: Page, planned_service: Service, tmp_path: Path
) -> None:
    await open_plan(page, planned_service)
    picker = page.get_by_test_id("plan-import")
    await picker.set_input_files(FilePayload(name="broken.kml", mimeType="", buffer=b"<kml><Placemark>"))
    await expect(page.get_by_test_id("import-refusal")).to_contain_text("broken.kml: The file is not well-formed KML")
    huge = tmp_path / "huge.json"
    huge.write_bytes(b" " * (MAX_FILE_BYTES + 1))
    await picker.set_input_files(huge)
    await expect(page.get_by_test_id("import-refusal")).to_contain_text("huge.json: The file is larger than 4 MiB")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")
    for name, content in (("area.geojson", geojson()), ("pond.kml", kml()), ("home.plan", qgc_plan())):
        await picker.set_input_files(FilePayload(name=name, mimeType="", buffer=content))
        await page.get_by_test_id("import-ok").click()
        await expect(page.get_by_test_id("import-dialog")).to_have_count(0)
    await expect(page.get_by_test_id("import-refusal")).to_have_text("")
    await expect(page.get_by_test_id("shape-no_go[0]")).to_contain_text("4 corners")
    await expect(page.get_by_test_id("shape-launch")).to_contain_text("set")
    await page.get_by_test_id("shape-area").click()
    await page.get_by_test_id("unit-globe").click()
    await expect(page.get_by_test_id("vertex-0")).to_have_value(re.compile("N, .*E$"))


async def test_positions_are_shown_in_the_chosen_notation_and_read_in_any(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    await page.get_by_test_id("unit-globe").click()
    await page.get_by_test_id("settings-open").click()
    await page.get_by_test_id("notation-mgrs").click()
    await page.get_by_test_id("settings-close").click()
    corner = page.get_by_test_id("vertex-0")
    await expect(corner).to_have_value(re.compile("^33U VP"))
    await corner.fill("somewhere")
    await expect(page.get_by_test_id("vertex-0-problem")).to_contain_text("or MGRS")
    south, west = ORIGIN.latitude_deg - 1e-3, ORIGIN.longitude_deg - 1e-3
    await corner.fill(dms(south, west))
    await corner.blur()
    await expect(corner).to_have_value(mgrs_text(south, west))

    await page.reload()
    await page.get_by_test_id("unit-globe").click()
    await expect(corner).to_have_value(re.compile("^33U VP"))


async def test_lengths_are_typed_in_the_chosen_units(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    spacing = page.get_by_test_id("plan-layer_spacing_m")
    await spacing.fill("4")
    for units, shown in (("imperial", "13.1"), ("metric", "4")):
        await page.get_by_test_id("settings-open").click()
        await page.get_by_test_id(f"units-{units}").click()
        await page.get_by_test_id("settings-close").click()
        await expect(spacing).to_have_value(shown)


async def test_changes_are_taken_back_and_made_again(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    undo, redo = page.get_by_test_id("plan-undo"), page.get_by_test_id("plan-redo")
    speed, layers = page.get_by_test_id("plan-cruise_speed_mps"), page.get_by_test_id("plan-layer_spacing_m")
    await expect(undo).to_be_disabled()
    await speed.fill("7")
    await layers.fill("4")
    await layers.press("Control+z")
    await expect(speed).to_have_value("7")  # the field has its own undo
    await layers.fill("4")
    await page.get_by_test_id("vertex-remove-3").click()
    await expect(page.get_by_test_id("shape-area")).to_contain_text("3 corners")

    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("view-plan").click()
    await page.get_by_test_id("shape-area").press("Control+z")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")
    await expect(redo).to_be_enabled()
    await undo.click()
    await expect(layers).to_have_value("2.5")
    await page.keyboard.press("Control+Shift+Z")
    await expect(layers).to_have_value("4")
    await redo.click()
    await expect(page.get_by_test_id("shape-area")).to_contain_text("3 corners")
    await expect(redo).to_be_disabled()

    await page.get_by_test_id("plan-reload").click()
    await expect(speed).to_have_value("10")
    await expect(undo).to_be_disabled()


async def test_parameters_of_the_strategy_are_chosen_and_refused_beside_their_fields(
    page: Page, planned_service: Service
) -> None:
    await open_plan(page, planned_service)
    form = page.get_by_test_id("strategy-parameters")
    await form.locator("summary").click()
    gamma = page.get_by_test_id("plan-strategy_parameters.gamma")
    await expect(gamma).to_have_value("0.9")
    await expect(form).to_contain_text("Above 0 and below 1, default 0.9.")
    await gamma.fill("7")
    problem = page.get_by_test_id("plan-strategy_parameters.gamma-problem")
    await expect(problem).to_have_text("gamma must be above 0 and below 1, but is 7.")
    await expect(page.get_by_test_id("plan-apply")).to_be_disabled()
    await page.get_by_test_id("reset-gamma").click()
    await expect(problem).to_have_text("")
    await expect(gamma).to_have_value("0.9")
    await gamma.fill("0.8")
    await page.get_by_test_id("plan-strategy_parameters.leader_stabilised").uncheck()
    await expect(form).to_contain_text("2 changed")
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    await page.get_by_test_id("plan-apply").click()
    await expect(page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")
    applied = planned_service.mission.settings.strategy_parameters
    assert applied == {"gamma": 0.8, "leader_stabilised": False}


async def test_observers_see_the_estimate_and_change_nothing(page: Page, guarded_plan: Service) -> None:
    await open_plan(page, guarded_plan)
    estimate = page.get_by_test_id("plan-estimate")
    await expect(estimate).to_contain_text("Coverage")
    await expect(estimate).to_contain_text("Only operators can change the plan.")
    await expect(page.get_by_test_id("plan-vehicles")).to_be_disabled()
    for control in ("plan-apply", "plan-undo", "plan-import", "plan-files", "draw", "add-no-go"):
        await expect(page.get_by_test_id(control)).to_have_count(0)
    answer = await page.request.post(f"{guarded_plan.url}api/plan/apply", data={"vehicles": 3})
    assert answer.status == 403


async def test_what_another_screen_has_saved_is_replaced_knowingly(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    name, answer = page.get_by_test_id("plan-name"), page.get_by_test_id("plan-files-answer")
    await name.fill("valley/../east?")
    await page.get_by_test_id("plan-save").click()
    await expect(answer).to_contain_text("is not a valid plan name")
    await name.fill("valley")
    other = await page.request.put(f"{planned_service.url}api/plans/valley", data={"vehicles": 3})
    assert other.ok
    await page.get_by_test_id("plan-save").click()
    await expect(answer).to_contain_text("A plan named 'valley' already exists")
    await expect(page.get_by_test_id("saved-valley")).to_be_visible()
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()
    await hold(page, "plan-replace", expect(answer).to_have_text("Saved as valley."))
    saved = await (await page.request.get(f"{planned_service.url}api/plans/valley")).json()
    assert saved["vehicles"] == 8


async def test_bad_files_and_areas_are_refused_where_they_were_given(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    picker, refusal = page.get_by_test_id("plan-import"), page.get_by_test_id("import-refusal")
    ring = [[14.0 + 1e-6 * corner, 48.0] for corner in range(2_000)]
    utm = {"type": "name", "properties": {"name": "EPSG:32633"}}
    bomb = b'<!DOCTYPE kml [<!ENTITY a "boom"><!ENTITY b "&a;&a;&a;&a;">]><kml>&b;</kml>'
    for content, words in (
        (geojson()[:-9], "damaged"),
        (bomb, "document type or entities"),
        (json.dumps({"type": "Polygon", "coordinates": [square(1e-3)], "crs": utm}).encode(), "WGS 84"),
        (json.dumps({"type": "Polygon", "coordinates": [ring]}).encode(), "2000 points; simplify it to 500"),
        (b'{"type": "Point", "coordinates": [NaN, 48.0]}', "not a latitude and longitude"),
    ):
        await picker.set_input_files(FilePayload(name="bad", mimeType="", buffer=content))
        await expect(refusal).to_contain_text(words)
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")

    swapped = [[latitude_deg, longitude_deg] for longitude_deg, latitude_deg in square(1e-3)]
    document = json.dumps({"type": "Polygon", "coordinates": [swapped]}).encode()
    problem = page.get_by_test_id("shape-problem-area")
    await picker.set_input_files(FilePayload(name="swapped", mimeType="", buffer=document))
    await page.get_by_test_id("import-ok").click()
    await expect(problem).to_contain_text("latitude and longitude swapped")
    await expect(page.get_by_test_id("plan-apply")).to_be_disabled()
    await page.get_by_test_id("plan-undo").click()
    await expect(problem).to_have_text("")

    await page.get_by_test_id("vertex-2-0").fill("90000")
    await expect(problem).to_contain_text("5 km are allowed")
    await page.get_by_test_id("shape-clear").click()
    await expect(problem).to_contain_text("is empty; draw it")
    await expect(page.get_by_test_id("plan-blocked")).to_be_visible()


async def test_points_in_no_go_zones_are_told_beside_them(page: Page, planned_service: Service) -> None:
    await open_plan(page, planned_service)
    picker = page.get_by_test_id("plan-import")
    dialog, take = page.get_by_test_id("import-dialog"), page.get_by_test_id("import-ok")
    await picker.set_input_files(FilePayload(name="pond.kml", mimeType="", buffer=kml()))
    first = await dialog.element_handle()
    await take.click()
    await expect(dialog).to_have_count(0)
    await picker.set_input_files(FilePayload(name="home.plan", mimeType="", buffer=qgc_plan()))
    await expect(dialog).to_be_visible()
    await first.evaluate("gone => gone.dispatchEvent(new Event('close'))")  # as a slow browser tells it: late
    await take.click()
    problem = page.get_by_test_id("shape-problem-launch")
    await expect(problem).to_have_text("The launch point is inside of no-go zone 1; move one of them.")
    await expect(page.get_by_test_id("plan-apply")).to_be_disabled()
