"""The page without its station: it opens with the last state, says how old that is, and commands nothing."""

from __future__ import annotations

import pytest
from playwright.async_api import Browser, Page, expect

from tests.browser.conftest import OPERATOR_CODE, WITHOUT_WEBGL, PageRecord, Service, new_page
from tests.browser.pages import open_page, sign_in, start_mission

pytestmark = pytest.mark.asyncio(loop_scope="session")

TWO_HOURS_LATER = "const now = Date.now; Date.now = () => now() + 7_320_000;"
UNTIL_KEPT = """async () => {
    await navigator.serviceWorker.ready;
    for (;;) {
        const database = await new Promise((resolve) => {
            const request = indexedDB.open("aos-gcs", 1);
            request.onupgradeneeded = () => request.result.createObjectStore("last-state");
            request.onsuccess = () => resolve(request.result);
        });
        const state = await new Promise((resolve) => {
            const request = database.transaction("last-state").objectStore("last-state").get("state");
            request.onsuccess = () => resolve(request.result);
        });
        database.close();
        if (state?.mission?.vehicles.some((vehicle) => vehicle.armed)) return;
        await new Promise((resolve) => setTimeout(resolve, 100));
    }
}"""
"""Wait for a state with vehicles in the air; states are kept every five seconds."""
ALL_THAT_IS_STORED = """async () => {
    const found = [document.cookie, JSON.stringify(localStorage)];
    for (const name of await caches.keys()) {
        const cache = await caches.open(name);
        for (const request of await cache.keys()) found.push(request.url);
    }
    const database = await new Promise((resolve) => {
        const request = indexedDB.open("aos-gcs");
        request.onsuccess = () => resolve(request.result);
    });
    found.push(JSON.stringify(await new Promise((resolve) => {
        const request = database.transaction("last-state").objectStore("last-state").getAll();
        request.onsuccess = () => resolve(request.result);
    })));
    return found.join("\\n");
}"""
BLOCK_STORAGE = """() => Object.defineProperty(window, "indexedDB", {
    get() { throw new DOMException("The operation is insecure.", "SecurityError"); },
})"""


async def test_the_page_opens_without_the_station_with_the_last_state(
    guarded_service: Service, browser: Browser
) -> None:
    async with new_page(browser, is_kept=True) as page:
        await page.add_init_script(WITHOUT_WEBGL)
        await page.goto(f"{guarded_service.url}#code={OPERATOR_CODE}")
        await sign_in(page, "Robin")
        await expect(page.get_by_test_id("sign-in")).to_have_count(0)
        await start_mission(page)
        await page.evaluate(UNTIL_KEPT)
        stored = await page.evaluate(ALL_THAT_IS_STORED)
        assert OPERATOR_CODE not in stored
        assert "/api/" not in "\n".join(line for line in stored.splitlines() if line.startswith("http"))

        await guarded_service.stop()
        await page.add_init_script(TWO_HOURS_LATER)
        await page.reload()
        await see_the_last_state(page)
        await command_nothing(page)

        await guarded_service.start()
        await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
        await expect(page.get_by_test_id("kept-banner")).to_have_count(0)
        await expect(page.get_by_test_id("another-mission")).to_have_count(0)
        await expect(page.get_by_test_id("vehicle-1")).to_have_attribute("data-stale", "false")


async def see_the_last_state(page: Page) -> None:
    banner = page.get_by_test_id("kept-banner")
    await expect(banner).to_contain_text("No connection to the station. Last state, 20")
    await expect(page.get_by_test_id("kept-age")).to_have_text("2\u202fh old.")
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "lost")
    await expect(page.get_by_test_id("phase")).not_to_have_text("Ready")
    await expect(page.get_by_test_id("vehicle-1")).to_have_attribute("data-stale", "true")
    await expect(page.get_by_test_id("vehicle-8")).to_be_attached()
    await expect(page.get_by_test_id("banner")).to_have_count(0)


async def command_nothing(page: Page) -> None:
    land = page.get_by_test_id("action-land")
    await expect(land).to_be_disabled()
    await expect(land).to_have_attribute(
        "title", "Not available: no connection to the station. Use the remote control."
    )
    await page.get_by_test_id("hold-all").click()
    await expect(page.get_by_test_id("results-error")).to_contain_text("Not confirmed: the station cannot be reached.")


async def test_a_page_says_that_the_station_has_another_and_that_nothing_can_be_kept(
    service: Service, page: Page, page_record: PageRecord
) -> None:
    await open_page(page, service.url)
    await page.evaluate(BLOCK_STORAGE)
    await expect(page.get_by_test_id("other-page")).to_have_count(0)
    await service.stop()
    await expect(page.get_by_test_id("banner")).to_be_visible()
    await page.route(service.url, lambda route: route.fulfill(body="<script src='/assets/index-other.js'></script>"))
    await service.start()
    await expect(page.get_by_test_id("other-page")).to_contain_text("The station has another version of this page.")
    await page.get_by_test_id("settings-open").click()
    await expect(page.get_by_test_id("offline-state")).to_contain_text("its storage is full or blocked")
    await page.get_by_test_id("settings-close").click()
    await page.unroute(service.url)
    await page.get_by_test_id("reload").click()
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")
    await expect(page.get_by_test_id("other-page")).to_have_count(0)
    assert page_record.foreign_requests == []
