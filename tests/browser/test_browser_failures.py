"""What goes wrong in flight, as an operator sees it: real processes are killed and frozen, the page alone tells."""

from __future__ import annotations

import re
import signal
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from aos_gcs.mission.model.events import EventKind, NoticeRecord
from aos_gcs.store.reader import MissionReader
from tests.browser.conftest import WITHOUT_WEBGL, new_page
from tests.browser.pages import open_page, wait_for
from tests.browser.station import FLIGHT_MS, Station, launch, sign_in_as_operator
from tests.fakes.program import Program

pytestmark = [pytest.mark.asyncio(loop_scope="session"), pytest.mark.usefixtures("dashboard_build")]

WORLD = ("--no-render", "--trees-per-ha", "0", "--image-size", "64")
"""There is nothing to be found: the swarm scans until something goes wrong."""
BESIDE = ("--origin", "48.3,14.3002,260")
"""Origin of a second simulator, whose vehicles must not stand where those of the first one do."""
LONG_AREA_ENU_M = ((-25.0, 8.0), (25.0, 8.0), (25.0, 408.0), (-25.0, 408.0))
"""The scan does not come to its end, however long a busy machine takes to show the page."""
NO_GO_ENU_M = ((-12.5, 30.0), (12.5, 30.0), (12.5, 70.0), (-12.5, 70.0))
"""Before one of the two vehicles on either leg: the other one goes on for a while, then the area is left behind."""
CRITICAL_TONES_HZ = [880, 660, 880]
HEAR_TONES = """window.tones = [];
window.OscillatorNode = class extends OscillatorNode {
    constructor(context, options) {
        super(context, options);
        window.tones.push(options.frequency);
    }
};"""


@pytest_asyncio.fixture(loop_scope="session")
async def listening_page(browser: Browser) -> AsyncIterator[Page]:
    """A page that keeps the tones that it plays."""
    async with new_page(browser) as page:
        await page.add_init_script(WITHOUT_WEBGL)
        await page.add_init_script(HEAR_TONES)
        yield page


async def start(page: Page, station: Station) -> None:
    """Sign in, and start the mission once its preflight has passed."""
    await open_page(page, station.url)
    await sign_in_as_operator(page)
    await launch(page, "action-start")


async def wait_for_step(page: Page, number: int) -> None:
    condition = "number => Number(document.querySelector('[data-testid=step]').textContent) >= number"
    await page.wait_for_function(condition, arg=number, timeout=FLIGHT_MS)


async def current_step(page: Page) -> int:
    return int(await page.get_by_test_id("step").inner_text())


async def events_shown(page: Page) -> list[str]:
    """Return the words of all events on the page, oldest first."""
    texts = await page.get_by_test_id("event").locator("span").all_inner_texts()
    return [re.sub("^(Warning|Critical|Found) ", "", text) for text in reversed(texts)]


def events_recorded(folder: Path) -> list[str]:
    """Return the same from the record."""
    with MissionReader(folder) as reader:
        notices = [event.data for event in reader.events() if event.kind is EventKind.NOTICE]
    return [
        notice.text if notice.vehicle_id is None else f"Vehicle {notice.vehicle_id}: {notice.text}"
        for notice in notices
        if isinstance(notice, NoticeRecord)
    ]


def check_none_lost_or_doubled(shown: list[str], recorded: list[str]) -> None:
    """The first ones may be older than the dashboard, the last ones on their way, to the page or to the disk."""
    since = recorded[recorded.index(shown[0]) :]
    both = min(len(shown), len(since))
    assert shown[:both] == since[:both]


async def see_a_refused_waypoint(page: Page) -> None:
    """See the reason why a vehicle does not go on."""
    await expect(page.get_by_test_id("vehicles")).to_contain_text("no-go zone 1", timeout=FLIGHT_MS)


async def see_a_lost_vehicle(page: Page, last_step: int) -> None:
    """See and hear that vehicle 3 is lost, that the others go on, and that it cannot be reached.

    Its last step is that before it was lost: a slow page may show the loss when the others have come to the no-go zone.
    """
    row = page.get_by_test_id("vehicle-3")
    await expect(row).to_have_attribute("data-stale", "true", timeout=FLIGHT_MS)
    await expect(page.get_by_test_id("task-3")).to_have_text("Link lost", timeout=FLIGHT_MS)
    alert = page.get_by_test_id("alert-bar")
    await expect(alert).to_have_attribute("data-severity", "critical")
    await expect(alert).to_contain_text("Vehicle 3: link lost")
    await wait_for(page, "tones => window.tones.join().includes(tones.join())", CRITICAL_TONES_HZ)

    await wait_for_step(page, last_step + 2)
    await expect(page.get_by_test_id("vehicle-1")).to_have_attribute("data-stale", "false")
    await page.get_by_test_id("select-3").click()
    await page.get_by_test_id("action-hold").click()
    result = page.get_by_test_id("result-3")
    await expect(result).to_have_attribute("data-accepted", "false")
    await expect(result).to_contain_text("link lost: it cannot be reached")


async def outlive_a_freeze(page: Page, service: Program) -> None:
    """See that the flight's process stands still, which the dashboard's tells, and that it goes on."""
    banner = page.get_by_test_id("silent-banner")
    service.stop(signal.SIGSTOP)
    await expect(banner).to_be_visible()
    elapsed = page.get_by_test_id("elapsed")
    frozen_at = await elapsed.inner_text()
    service.stop(signal.SIGCONT)
    await expect(banner).to_have_count(0)
    await expect(elapsed).not_to_have_text(frozen_at, timeout=FLIGHT_MS)


@pytest.mark.timeout(600)
async def test_the_page_shows_what_fails_in_flight_and_outlives_its_service(
    listening_page: Page, tmp_path: Path
) -> None:
    """One mission for all: it takes longer to launch one than to look."""
    page = listening_page
    banner = page.get_by_test_id("banner")
    station = Station(tmp_path, 3, no_go_enu_m=(NO_GO_ENU_M,), area_enu_m=LONG_AREA_ENU_M)
    async with station.fly(2, *WORLD):
        async with (
            station.fly(1, *WORLD, *BESIDE, "--first-system-id", "3", name="another") as another,
            station.serve() as service,
        ):
            await start(page, station)
            await see_a_refused_waypoint(page)
            last_step = await current_step(page)
            another.stop(signal.SIGKILL)
            await see_a_lost_vehicle(page, last_step)
            await outlive_a_freeze(page, service)
            service.stop(signal.SIGKILL)
            await expect(banner).to_be_visible()
            shown = await events_shown(page)
        check_none_lost_or_doubled(shown, events_recorded(station.mission_folders[0]))
        async with station.serve():
            await expect(banner).to_have_count(0)
            await expect(page.get_by_test_id("step")).to_have_text("0")
            await expect(page.get_by_test_id("another-mission")).to_contain_text(station.mission_folders[1].name)
            await expect(page.get_by_test_id("event").first).to_be_visible()
            # The new service must know that the vehicles fly before it can hold them.
            await expect(page.get_by_test_id("height-1")).to_have_text(re.compile(r"^[1-9]\d"), timeout=FLIGHT_MS)
            await page.get_by_test_id("hold-all").click()
            await expect(page.get_by_test_id("result-1")).to_have_attribute("data-accepted", "true")
            check_none_lost_or_doubled(await events_shown(page), events_recorded(station.mission_folders[1]))
