"""The dashboard of ``aos-gcs demo`` in a real browser, from the first telemetry to the last landing."""

from __future__ import annotations

import re
import signal
import socket
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Page, expect

from aos_gcs.mission.settings import DetectionSettings
from tests.browser.pages import TIMEOUT_MS, confirm, place_m, sign_in, wait_for_visibility
from tests.fakes.program import Program, running

pytestmark = pytest.mark.asyncio(loop_scope="session")

VEHICLES = 3
SMALL = (
    "--vehicles",
    str(VEHICLES),
    "--image-size",
    "128",
    "--trees-per-ha",
    "30",
    "--seed",
    "2",
    "--speed",
    "4",
    "--wait",
)
"""Slow enough for the operator to act in flight, on a machine that is busy with the page as well."""
HOVERING_M = 1.0
"""How far a vehicle that holds may drift."""
STILL_MS = 2000
"""Longer than vehicles hover at the waypoints of a mission that goes on."""


@pytest_asyncio.fixture(loop_scope="session")
async def demo(tmp_path: Path, dashboard_build: None) -> AsyncIterator[tuple[Program, str]]:  # noqa: ARG001 - its check
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    async with running(tmp_path, "demo", *SMALL, "--port", str(port), "--json") as program:
        await program.until_logged("Dashboard for operators: ", 60)
        yield program, program.operator_url


async def wait_for(page: Page, condition: str, argument: object) -> None:
    await page.wait_for_function(condition, arg=argument, timeout=TIMEOUT_MS)


async def wait_until_moved(page: Page, vehicle_id: int, place: tuple[float, float], distance_m: float) -> None:
    condition = """([id, east, north, distance]) => {
        const place = document.querySelector(`[data-testid=vehicle-${id}]`)?.dataset;
        return place && Math.hypot(place.east - east, place.north - north) > distance;
    }"""
    await wait_for(page, condition, [vehicle_id, *place, distance_m])


async def wait_until_still(page: Page) -> None:
    """Wait until no vehicle has left its place for a while."""
    condition = """([count, distance, duration]) => {
        const places = [...document.querySelectorAll("[data-testid^=vehicle-]")]
            .filter(row => row.dataset.east !== undefined)
            .map(row => [Number(row.dataset.east), Number(row.dataset.north)]);
        const seen = window.stillPlaces;
        const isStill = seen?.places.length === places.length && places.every(([east, north], i) =>
            Math.hypot(east - seen.places[i][0], north - seen.places[i][1]) <= distance);
        if (!isStill) window.stillPlaces = { places, since: performance.now() };
        return places.length === count && isStill && performance.now() - seen.since >= duration;
    }"""
    await wait_for(page, condition, [VEHICLES, HOVERING_M, STILL_MS])


@pytest.mark.timeout(300)
async def test_an_operator_launches_holds_resumes_and_returns_a_swarm(map_page: Page, demo, page_record) -> None:
    program, url = demo
    phase = map_page.get_by_test_id("phase")
    await map_page.goto(url)
    await sign_in(map_page, "Ada")
    await expect(map_page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    for vehicle_id in range(1, VEHICLES + 1):
        row = map_page.get_by_test_id(f"vehicle-{vehicle_id}")
        await expect(row).to_have_attribute("data-east", re.compile(r"\d"))
    home = await place_m(map_page, 1)
    await map_page.keyboard.press("r")
    await map_page.get_by_test_id("launch").click()
    await confirm(map_page)
    await map_page.keyboard.press("f")
    await wait_until_moved(map_page, 1, home, 5.0)
    await map_page.keyboard.press("u")
    await wait_for_visibility(map_page, DetectionSettings().threshold_m2)
    await map_page.keyboard.press("f")

    await map_page.get_by_test_id("hold-all").click()
    await expect(map_page.get_by_test_id("suspension")).to_have_text("held")
    for vehicle_id in range(1, VEHICLES + 1):
        result = map_page.get_by_test_id(f"result-{vehicle_id}")
        await expect(result).to_have_attribute("data-accepted", "true")
    await wait_until_still(map_page)
    await expect(map_page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    step = int(await map_page.get_by_test_id("step").inner_text())

    await map_page.get_by_test_id("action-resume").click()
    await expect(map_page.get_by_test_id("suspension")).to_have_count(0)
    next_step = "last => Number(document.querySelector('[data-testid=step]').textContent) > last"
    await wait_for(map_page, next_step, step)

    await map_page.get_by_test_id("action-return").click()
    await confirm(map_page)
    await expect(phase).to_have_text("return")
    for vehicle_id in range(1, VEHICLES + 1):
        await expect(map_page.get_by_test_id(f"task-{vehicle_id}")).to_have_text("landed")
    await program.until(lambda: bool(program.output), 60)
    assert program.result()["landed"] == VEHICLES
    # The dashboard is still served: a page that had lost it would have said so here.
    assert page_record.errors == []
    assert page_record.foreign_requests == []
    program.stop(signal.SIGTERM)
    await program.ended(60)
