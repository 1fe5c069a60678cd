"""Every view on every screen: nothing overlaps, nothing is out of reach, and fingers have room."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.ports import Severity
from tests.browser.conftest import WITHOUT_WEBGL, Service
from tests.browser.pages import VIEWS, open_page

pytestmark = pytest.mark.asyncio(loop_scope="session")

SMALLEST_TARGET_PX = 44
SCREENS_PX = ((640, 400), (800, 1280), (1280, 800), (1920, 1080))
PHONE_PX = (390, 844)
LOWEST_WHOLE_PX = 800
"""Height below which the page may be scrolled."""

# Names of panels that overlap where they are visible, and of those squeezed flat. A scroll container clips its panels.
OVERLAPS = """() => {
    const clip = (box, frame) => ({
        left: Math.max(box.left, frame.left), right: Math.min(box.right, frame.right),
        top: Math.max(box.top, frame.top), bottom: Math.min(box.bottom, frame.bottom), height: box.height,
    });
    const visible = (panel) => {
        const scroll = panel.parentElement.closest(".scroll");
        const box = panel.getBoundingClientRect();
        return scroll === null ? clip(box, box) : clip(box, scroll.getBoundingClientRect());
    };
    const panels = [...document.querySelectorAll("main .panel")].filter((panel) => !panel.querySelector(".panel"));
    const boxes = panels.map((panel) => ({ name: panel.dataset.testid, box: visible(panel) }));
    const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
    const pairs = boxes.flatMap((a, i) => boxes.slice(i + 1).map((b) => [a, b]));
    const overlapping = pairs.filter(([a, b]) => !apart(a.box, b.box)).map(([a, b]) => `${a.name} and ${b.name}`);
    const flat = boxes.filter(({ box }) => box.height < 30).map(({ name }) => `${name} is flat`);
    return [...overlapping, ...flat];
}"""

# Place and size of the map and of all controls but those of banners and alerts, rounded to pixels.
BOXES = """() => Object.fromEntries(
    [...document.querySelectorAll("[data-testid=map], .header button, .nav a, main button, main input")]
        .filter((element) => element.closest(".banner") === null)
        .map((element) => [element, element.getBoundingClientRect()])
        .map(([{ dataset }, { x, y, width, height }]) => [dataset.testid, [x, y, width, height].map(Math.round)]),
)"""

IS_CUT = """(list) => {
    const [inner, outer] = [list, list.closest(".map")].map((element) => element.getBoundingClientRect());
    return inner.bottom > outer.bottom || inner.right > outer.right;
}"""

# Texts that touch the border of their panel, or lie beyond it.
TEXT_BESIDE_ITS_PANEL = """(panel) => {
    const frame = panel.getBoundingClientRect();
    return [...panel.querySelectorAll("dt, dd")]
        .map((element) => ({ text: element.textContent, box: element.getBoundingClientRect() }))
        .filter(({ box }) => box.left < frame.left + 4 || box.right > frame.right - 4)
        .map(({ text }) => text);
}"""

# Checkboxes of rows are smaller: the whole row takes the touch.
SMALL_TARGETS = """(smallest_px) =>
    [...document.querySelectorAll("button, a, input:not([type=checkbox]), select, summary")]
        .map((element) => ({ element, box: element.getBoundingClientRect() }))
        .filter(({ box }) => box.width > 0 && Math.min(box.width, box.height) < smallest_px - 0.5)
        .map(({ element, box }) => `${element.outerHTML.slice(0, 120)}: ${box.width} x ${box.height}`)"""


@pytest_asyncio.fixture(loop_scope="session")
async def tablet(browser: Browser) -> AsyncIterator[Page]:
    """A page that is touched."""
    context = await browser.new_context(viewport={"width": 800, "height": 1280}, has_touch=True, is_mobile=True)
    page = await context.new_page()
    await page.add_init_script(WITHOUT_WEBGL)
    yield page
    await context.close()


async def test_every_view_fits_every_screen(page: Page, service: Service) -> None:
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    await open_page(page, service.url)
    await expect(page.get_by_test_id("alert-bar")).to_be_visible()
    await page.evaluate("document.fonts.ready.then(() => true)")
    for view in VIEWS:
        await page.get_by_test_id(f"view-{view}").click()
        await expect(page.locator(f"main.view-{view} .panel").first).to_be_visible()
        for width_px, height_px in SCREENS_PX:
            case = f"{view}, {width_px} x {height_px}"
            await page.set_viewport_size({"width": width_px, "height": height_px})
            await expect(page.get_by_test_id("hold-all")).to_be_in_viewport(ratio=1)
            assert await page.evaluate(OVERLAPS) == [], case
            assert await page.evaluate("document.documentElement.scrollWidth") <= width_px, case
            if height_px >= LOWEST_WHOLE_PX:
                assert await page.evaluate("document.documentElement.scrollHeight") <= height_px, case


async def boxes(page: Page) -> dict[str, object]:
    """Return where the map and all controls are, on every screen."""
    found: dict[str, object] = {}
    for width_px, height_px in (*SCREENS_PX, PHONE_PX):
        await page.set_viewport_size({"width": width_px, "height": height_px})
        found |= {f"{width_px} x {height_px}: {name}": box for name, box in (await page.evaluate(BOXES)).items()}
    return found


async def test_neither_the_map_nor_any_control_moves_when_banners_and_alerts_come_and_go(
    page: Page, service: Service
) -> None:
    await open_page(page, service.url)
    await expect(page.get_by_test_id("vehicle-1")).to_be_visible()
    await page.evaluate("document.fonts.ready.then(() => true)")
    before = await boxes(page)
    assert {"1280 x 800: map", "1280 x 800: hold-all", "390 x 844: action-hold"} <= before.keys()

    service.mission.notify(Severity.CRITICAL, "link lost: " + "it has not been heard for a long time " * 5, 6)
    service.mission.notify(Severity.WARNING, "battery at 24 %", 2)
    await expect(page.get_by_test_id("alert-list")).to_be_visible()
    assert await boxes(page) == before
    service.freeze()
    await expect(page.get_by_test_id("silent-banner")).to_be_visible()
    assert await boxes(page) == before
    await service.stop()
    await expect(page.get_by_test_id("banner")).to_be_visible()
    await expect(page.get_by_test_id("alert-bar")).to_be_visible()
    assert await boxes(page) == before

    await service.start()
    service.fly()
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    await expect(page.get_by_test_id("banner")).to_have_count(0)
    for severity in ("critical", "warning"):
        await expect(page.get_by_test_id("alert-bar")).to_have_attribute("data-severity", severity)
        await page.get_by_test_id("alert-acknowledge").click()
    await expect(page.get_by_test_id("alert-bar")).to_have_count(0)
    assert await boxes(page) == before


async def test_all_layers_of_the_map_are_within_reach(map_page: Page, service: Service) -> None:
    await open_page(map_page, service.url)
    await map_page.get_by_test_id("map-layers").click()
    layers = map_page.locator(".layer-list")
    last = layers.locator("label").last
    for width_px, height_px in (*SCREENS_PX, PHONE_PX):
        await map_page.set_viewport_size({"width": width_px, "height": height_px})
        assert await layers.evaluate(IS_CUT) is False, f"{width_px} x {height_px}"
        await last.scroll_into_view_if_needed()
        await expect(last).to_be_in_viewport(ratio=0.99)


async def test_all_that_is_touched_is_as_large_as_a_finger(tablet: Page, service: Service) -> None:
    service.mission.notify(Severity.CRITICAL, "link lost", 6)
    service.mission.notify(Severity.WARNING, "battery at 24 %", 2)
    await open_page(tablet, service.url)
    for view in VIEWS:
        await tablet.get_by_test_id(f"view-{view}").tap()
        await expect(tablet.locator(f"main.view-{view} .panel").first).to_be_visible()
        assert await tablet.evaluate(SMALL_TARGETS, SMALLEST_TARGET_PX) == [], view
    await tablet.get_by_test_id("alert-list").tap()
    assert await tablet.evaluate(SMALL_TARGETS, SMALLEST_TARGET_PX) == []
    await tablet.get_by_test_id("alert-dialog").get_by_label("Close the window").tap()
    await expect(tablet.get_by_test_id("alert-dialog")).to_have_count(0)


async def test_the_relay_says_who_leaves_when_and_nothing_of_it_is_cut(
    page: Page, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = service.mission.snapshot

    def with_relay() -> MissionSnapshot:
        snapshot = plain()
        one, two, three, *others = snapshot.vehicles
        leaving = (replace(one, leaves_in_s=312.0), replace(two, leaves_in_s=65.0), replace(three, is_ready=False))
        return replace(snapshot, vehicles=(*leaving, *others))

    monkeypatch.setattr(service.mission, "snapshot", with_relay)
    await open_page(page, service.url)
    relay = page.get_by_test_id("relay")
    await expect(relay.locator("dt")).to_have_text(["Leaves next: vehicle 2", "Vehicle 1", "Vehicle 3"])
    await expect(relay.locator("dd")).to_have_text(["in 01:05", "in 05:12", "on the ground: not confirmed as ready"])
    for width_px, height_px in SCREENS_PX:
        await page.set_viewport_size({"width": width_px, "height": height_px})
        assert await relay.evaluate(TEXT_BESIDE_ITS_PANEL) == [], f"{width_px} x {height_px}"
