"""A whole mission by the page alone: planned, prepared, flown, looked at, decided, ended, and seen again."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import pytest
from playwright.async_api import Page, expect

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from tests.browser.conftest import PageRecord
from tests.browser.pages import confirm, open_page, place_m, wait_for, wait_until_moved
from tests.browser.station import FLIGHT_MS, ORIGIN_DEG, Station, launch, sign_in_as_operator

pytestmark = pytest.mark.asyncio(loop_scope="session")

VEHICLES = 3
WORLD = ("--seed", "7", "--trees-per-ha", "30", "--image-size", "128")
"""Few trees, so that the person is seen whatever way the swarm takes."""
UNCAUTIOUS = ("--param", "FS_GCS_ENABLE=0")
"""A setting that fails preflight, and that an operator may override."""
AREA_NORTH_M = (22.0, 22.0, 62.0, 62.0)
"""Corner by corner, of the area that the operator wants: half of the configured one, with the person in its middle."""
REMARK = "lies still, in the open"
NEAR_M = 2.0
HOVERING_M = 1.0
"""Distance that a vehicle that holds may drift."""
STILL_MS = 2000
"""Longer than vehicles hover at the waypoints of a mission that goes on."""


async def plan_by_numbers(page: Page) -> None:
    estimate = page.get_by_test_id("plan-estimate")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")
    await expect(estimate).to_contain_text("0.40 ha")
    for corner, north_m in enumerate(AREA_NORTH_M):
        await page.get_by_test_id(f"vertex-{corner}-1").fill(f"{north_m:g}")
    await expect(estimate).to_contain_text("0.20 ha")
    await page.get_by_test_id("plan-apply").click()
    await expect(page.get_by_test_id("plan-answer")).to_contain_text("Plan applied")


async def answer_for_what_fails(page: Page) -> None:
    """Override the failed check of each vehicle; until the last one there is no launch, and none without a reason."""
    launch = page.get_by_test_id("launch")
    for vehicle_id in range(1, VEHICLES + 1):
        cell = page.get_by_test_id(f"check-{vehicle_id}-link-loss failsafe")
        await expect(cell).to_have_attribute("data-status", "fail")
        await expect(launch).to_be_disabled()
        await cell.click()
        await expect(page.get_by_test_id("override-ok")).to_be_disabled()
        await page.get_by_test_id("override-reason").fill("a pilot stands by")
        await page.get_by_test_id("override-ok").click()
        await expect(cell).to_have_attribute("data-status", "overridden")
    await expect(launch).to_be_enabled()
    await expect(page.locator("[data-status=fail]")).to_have_count(0)


async def watch_the_search(page: Page) -> None:
    """See the vehicles move, and a target."""
    home = await place_m(page, 1)
    await expect(page.get_by_test_id("phase")).to_have_text(re.compile("Scanning|Converging|Found"), timeout=FLIGHT_MS)
    await expect(page.get_by_test_id("task-1")).to_have_text("In swarm")
    await wait_until_moved(page, 1, home, 5.0)
    await expect(page.get_by_test_id("target-position").first).to_be_visible(timeout=FLIGHT_MS)


async def hold_and_resume(page: Page) -> None:
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("suspension")).to_have_text("Holding")
    for vehicle_id in range(1, VEHICLES + 1):
        await expect(page.get_by_test_id(f"result-{vehicle_id}")).to_have_attribute("data-accepted", "true")
    await wait_until_still(page)
    step = int(await page.get_by_test_id("step").inner_text())
    await page.get_by_test_id("action-resume").click()
    await expect(page.get_by_test_id("suspension")).to_have_count(0)
    await wait_for(page, "last => Number(document.querySelector('[data-testid=step]').textContent) > last", step)


async def wait_until_still(page: Page) -> None:
    """Wait until no vehicle has left its place for a while."""
    condition = """([count, distance, duration]) => {
        const places = [...document.querySelectorAll("tr[data-testid^=vehicle-]")]
            .filter(row => row.dataset.east !== undefined)
            .map(row => [Number(row.dataset.east), Number(row.dataset.north)]);
        const seen = window.stillPlaces;
        const isStill = seen?.places.length === places.length && places.every(([east, north], i) =>
            Math.hypot(east - seen.places[i][0], north - seen.places[i][1]) <= distance);
        if (!isStill) window.stillPlaces = { places, since: performance.now() };
        return places.length === count && isStill && performance.now() - seen.since >= duration;
    }"""
    await wait_for(page, condition, [VEHICLES, HOVERING_M, STILL_MS])


async def refocus(page: Page) -> None:
    """Look at a step from the ground up to the crowns."""
    step = int(await page.get_by_test_id("step").inner_text())
    await page.evaluate("step => { location.hash = `#/see?step=${step}`; }", step)
    await page.get_by_test_id("picture-thermal").click()
    label, picture = page.get_by_test_id("picture-label"), page.get_by_test_id("picture")
    await expect(label).to_have_text(re.compile(rf"Thermal, step {step}, plane at 0\.0"))
    ground = await picture.get_attribute("src")
    await page.get_by_test_id("height").fill("12")
    await expect(label).to_have_text(re.compile(rf"Thermal, step {step}, plane at 12\.0"))
    assert await picture.get_attribute("src") != ground
    await wait_for(page, "() => document.querySelector('[data-testid=picture]').naturalWidth > 0")


async def decide(page: Page, truth_enu_m: tuple[float, ...]) -> None:
    """Confirm the finding where it is, once it is announced: on a slow machine it is listed long before."""
    await expect(page.get_by_test_id("finding-1")).to_contain_text("Possible person", timeout=FLIGHT_MS)
    await page.get_by_test_id("finding-1").click()
    await wait_for(page, "() => document.querySelector('[data-testid=finding-1] img')?.naturalWidth > 0")
    position = await page.get_by_test_id("position-decimal").inner_text()
    latitude_deg, longitude_deg = (float(number) for number in re.findall(r"[\d.]+(?=°)", position))
    found_enu_m = LocalFrame(GeodeticPosition(*ORIGIN_DEG)).to_enu(
        GeodeticPosition(latitude_deg, longitude_deg, ORIGIN_DEG[2])
    )
    assert tuple(found_enu_m[:2]) == pytest.approx(truth_enu_m[:2], abs=NEAR_M)
    await page.get_by_test_id("judge-confirmed").click()
    await page.get_by_test_id("finding-comment").fill(REMARK)
    await page.get_by_test_id("finding-save").click()
    await expect(page.get_by_test_id("finding-save")).to_be_disabled()
    await expect(page.get_by_test_id("finding-status")).to_have_text("✓ confirmed · Ada")


async def come_home(page: Page) -> None:
    await expect(page.get_by_test_id("outcome")).to_have_text("Possible person", timeout=FLIGHT_MS)
    await page.get_by_test_id("action-return").click()
    await confirm(page)
    for vehicle_id in range(1, VEHICLES + 1):
        await expect(page.get_by_test_id(f"task-{vehicle_id}")).to_have_text("Landed", timeout=FLIGHT_MS)
    await expect(page.get_by_test_id("phase")).to_have_text("Finished")


async def begin_another_sortie(page: Page) -> None:
    """Ask for a new sortie: the same page and sign-in, another mission, its area proposed, and what was found."""
    await page.get_by_test_id("action-new_sortie").click()
    await expect(page.get_by_test_id("another-mission")).to_be_visible(timeout=FLIGHT_MS)
    await expect(page.get_by_test_id("outcome")).to_have_count(0)
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    await page.keyboard.press("p")
    await expect(page.get_by_test_id("plan-estimate")).to_contain_text("ha")
    await page.keyboard.press("r")
    await expect(page.get_by_test_id("check-1-link-loss failsafe")).to_have_attribute("data-status", "fail")
    await page.keyboard.press("d")
    await page.get_by_test_id("filter-confirmed").click()
    await expect(page.get_by_test_id("finding-1")).to_contain_text("earlier sortie")
    await page.get_by_test_id("finding-1").click()
    await expect(page.get_by_test_id("finding-status")).to_have_text("✓ confirmed · Ada")
    await expect(page.get_by_test_id("judge-rejected")).to_be_enabled()
    await page.keyboard.press("f")


async def see_it_again(page: Page) -> None:
    """Move through the record: to the last landing, to the finding, and back."""
    slider, row = page.get_by_test_id("replay-time"), page.get_by_test_id("vehicle-1")
    await expect(slider).to_be_enabled()
    end = await slider.get_attribute("max") or ""
    await slider.fill(end)
    await expect(page.get_by_test_id("phase")).to_have_text("Finished")
    await expect(row).to_have_attribute("data-north", re.compile(r"\d"))
    home = await place_m(page, 1)
    await page.get_by_role("button", name=re.compile(r"Finding 1 \(")).focus()
    await page.keyboard.press("Enter")
    await wait_until_moved(page, 1, home, 5.0)
    await slider.fill(end)
    await expect(page.get_by_test_id("phase")).to_have_text("Finished")
    events = page.get_by_test_id("event")
    for text in ("Ada: start", "Possible person", "· Finding 1", "Ada: return all"):
        await expect(events.filter(has_text=text).first).to_be_visible()
    await page.keyboard.press("d")
    await page.get_by_test_id("finding-1").click()
    await expect(page.get_by_test_id("finding-status")).to_have_text("✓ confirmed · Ada")
    await expect(page.get_by_test_id("finding-detail")).to_contain_text(REMARK)
    await expect(page.get_by_test_id("judge-rejected")).to_have_count(0)


def own_errors(record: PageRecord) -> list[str]:
    """Leave out refusals of pictures that are not on the disk yet, or wait for others: the page asks again."""
    return [error for error in record.errors if not re.search("status of (422|503)", error)]


@pytest.mark.timeout(600)
async def test_an_operator_leads_a_mission_from_the_plan_to_its_replay(
    page: Page,
    tmp_path: Path,
    page_record: PageRecord,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
) -> None:
    station = Station(tmp_path, VEHICLES)
    world_file = tmp_path / "world.json"
    async with (
        station.fly(VEHICLES, *WORLD, *UNCAUTIOUS, "--world-file", str(world_file)),
        station.serve() as service,
    ):
        await open_page(page, station.url, "plan")
        await sign_in_as_operator(page)
        await plan_by_numbers(page)
        await page.keyboard.press("r")
        await answer_for_what_fails(page)
        await launch(page, "launch")
        await page.keyboard.press("f")
        await watch_the_search(page)
        await hold_and_resume(page)
        await page.keyboard.press("s")
        await refocus(page)
        await page.keyboard.press("d")
        (person,) = json.loads(world_file.read_text(encoding="utf-8"))["targets"]
        await decide(page, person["position_enu_m"])
        await page.keyboard.press("f")
        await come_home(page)
        await service.until(lambda: "Recorded in" in service.output, 60)
        assert service.output.startswith("found: ")
        assert own_errors(page_record) == []
        await begin_another_sortie(page)
        service.stop(signal.SIGTERM)
        await expect(page.get_by_test_id("banner")).to_be_visible()
    # The record at the same address: the page comes back by itself.
    async with station.replay(station.mission_folders[0]):
        await expect(page.get_by_test_id("replay-bar")).to_contain_text("REPLAY")
        page_record.errors.clear()  # the browser's words on the service that was gone
        await sign_in_as_operator(page)
        await see_it_again(page)
        assert own_errors(page_record) == []
        assert page_record.foreign_requests == []
