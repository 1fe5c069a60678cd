"""What tests do on the dashboard, in its own words."""

from __future__ import annotations

import io
import re
from collections.abc import Awaitable

from PIL import Image
from playwright.async_api import Page, Route, expect

from tests.timing import scaled_s

VIEWS = ("plan", "prepare", "fly", "see", "wall", "understand", "decide")
TIMEOUT_MS = 1000 * scaled_s(20.0)
"""Far more than a page needs: the machine may be busy with other things."""


async def open_page(page: Page, url: str, view: str = "fly") -> None:
    """Open a view and wait until it is connected."""
    await page.goto(f"{url}#/{view}")
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "open")


async def sign_in(page: Page, name: str, code: str | None = None) -> None:
    """Fill in the open question for a name and the operators' code; without one, it came with the address."""
    await page.get_by_test_id("sign-in-name").fill(name)
    if code is not None:
        await page.get_by_test_id("sign-in-code").fill(code)
    await page.get_by_test_id("sign-in-ok").click()


async def confirm(page: Page) -> None:
    """Keep the button of the open question pressed until the command is sent."""
    await hold(page, "confirm-ok", expect(page.get_by_test_id("confirm")).to_have_count(0))


async def hold(page: Page, button: str, has_worked: Awaitable[None]) -> None:
    """Hold a button that has to be held until it has worked."""
    await page.get_by_test_id(button).hover()
    await page.mouse.down()
    await has_worked
    await page.mouse.up()


async def press_briefly(page: Page, button: str) -> None:
    """Press Enter on a button that has to be held, and let go at once: in the page, so that nothing comes between."""
    strokes = """button => ["keydown", "keyup"].forEach(
        kind => button.dispatchEvent(new KeyboardEvent(kind, { key: "Enter", bubbles: true, cancelable: true })))"""
    await page.get_by_test_id(button).evaluate(strokes)


async def start_mission(page: Page) -> None:
    """Start from the view Fly and wait until the vehicles have taken off."""
    await page.get_by_test_id("view-fly").click()
    await page.get_by_test_id("action-start").click()
    await confirm(page)
    await expect(page.get_by_test_id("phase")).to_have_text(re.compile("Forming line|Scanning|Converging|Found"))


async def place_m(page: Page, vehicle_id: int) -> tuple[float, float]:
    """East and north of a vehicle, as the fleet table has them."""
    row = page.get_by_test_id(f"vehicle-{vehicle_id}")
    return float(await row.get_attribute("data-east") or "nan"), float(await row.get_attribute("data-north") or "nan")


async def wait_for(page: Page, condition: str, argument: object = None) -> None:
    """Wait until a function of the page returns true; the page's own policy forbids plain expressions."""
    await page.wait_for_function(condition, arg=argument, timeout=TIMEOUT_MS)


async def wait_until_moved(page: Page, vehicle_id: int, place: tuple[float, float], distance_m: float) -> None:
    """Wait until the fleet table has a vehicle at some distance from a place."""
    condition = """([id, east, north, distance]) => {
        const place = document.querySelector(`[data-testid=vehicle-${id}]`)?.dataset;
        return place && Math.hypot(place.east - east, place.north - north) > distance;
    }"""
    await wait_for(page, condition, [vehicle_id, *place, distance_m])


async def wait_for_visibility(page: Page, lowest_m2: float) -> None:
    """Wait until the view Understand shows that much of a target."""
    condition = "lowest => Number(document.querySelector('[data-testid=visibility]')?.dataset.value) > lowest"
    await wait_for(page, condition, lowest_m2)


async def with_thumbnails(page: Page) -> None:
    """The scripted mission records no frames: let its findings have a picture all the same."""
    png = io.BytesIO()
    Image.new("RGB", (8, 8), (40, 90, 40)).save(png, "PNG")

    async def answer(route: Route) -> None:
        await route.fulfill(body=png.getvalue(), content_type="image/png")

    await page.route("**/api/findings/*/*.png*", answer)
