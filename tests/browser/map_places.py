"""Positions on the screen of places on the ground, as the map itself tells under the mouse, and what is drawn there."""

from __future__ import annotations

import asyncio
import io
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.async_api import Locator, Page, expect

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from tests.fakes.scripted_vehicle import ORIGIN
from tests.fakes.tiles import mercator
from tests.timing import scaled_s

DRAWING_TIMEOUT_S = scaled_s(30.0)
_FRAME = LocalFrame(ORIGIN)
_INSET = 0.2
"""Share of the map's width and height between its rim and the mouse."""
_SWITCH = """async shown => {
    const names = [...document.querySelectorAll(".layer-list [data-testid^=layer-]")].map(one => one.dataset.testid);
    const switchOf = name => document.querySelector(`.layer-list [data-testid=${name}]`);
    for (const name of names) {
        if (switchOf(name).checked !== shown.includes(name)) switchOf(name).click();
        await Promise.resolve();  // the page takes it in
    }
    return names.filter(name => switchOf(name).checked !== shown.includes(name));
}"""
"""Switches all layers before the map is drawn again, which takes a tenth of a second of processor each time; returns
those that did not change."""
_DRAW = "() => new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(drawn)))"


def place(east_m: float, north_m: float) -> GeodeticPosition:
    """Return a place on the ground."""
    return _FRAME.to_geodetic(np.array([east_m, north_m, 0.0]))


@dataclass(frozen=True, slots=True)
class MapPlaces:
    """The map's canvas, with two of its pixels and their places on the map of the world.

    The page is asked for latitude and longitude only; from there it is the test's own Web Mercator. Pixels count from
    the middle of the canvas.
    """

    canvas: Locator
    pixels: NDArray[np.float64]
    """Shape (2, 2): rows are pixels (x, y), right of and below the middle of the canvas."""
    world: NDArray[np.float64]
    """The same points from 0 to 1, shape (2, 2)."""

    def pixel(self, east_m: float, north_m: float, picture: NDArray[np.uint8]) -> tuple[float, float]:
        """Return where a place lies in a picture of the canvas."""
        share = (np.array(mercator(place(east_m, north_m))) - self.world[0]) / (self.world[1] - self.world[0])
        from_middle = self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
        x, y = from_middle + np.array(picture.shape[1::-1]) / 2.0
        return float(x), float(y)

    async def around(self, east_m: float, north_m: float, reach_px: int) -> NDArray[np.uint8]:
        """Return what the canvas shows at most so many pixels from a place, shape (2 reach + 1, 2 reach + 1, 3)."""
        picture = await self.picture()
        x, y = (int(value) for value in self.pixel(east_m, north_m, picture))
        return picture[y - reach_px : y + reach_px + 1, x - reach_px : x + reach_px + 1]

    async def picture(self) -> NDArray[np.uint8]:
        """Return what the canvas shows, shape (H, W, 3)."""
        shot = await self.canvas.screenshot()
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"))

    async def colour(self, east_m: float, north_m: float) -> tuple[int, int, int]:
        """Return the colour of the pixel at a place."""
        red, green, blue = (await self.around(east_m, north_m, 0))[0, 0]
        return int(red), int(green), int(blue)

    async def await_line(self, east_m: float, north_m: float, background: tuple[int, int, int]) -> None:
        """Wait until something else than the background is drawn at most two pixels from a place: a line is thin."""
        async with asyncio.timeout(DRAWING_TIMEOUT_S):
            while np.all(await self.around(east_m, north_m, 2) == background):  # noqa: ASYNC110
                await asyncio.sleep(0.2)

    async def await_colour(self, east_m: float, north_m: float, colour: str) -> None:
        """Wait until a place has a colour."""
        wanted = tuple(bytes.fromhex(colour.removeprefix("#")))
        async with asyncio.timeout(DRAWING_TIMEOUT_S):
            while await self.colour(east_m, north_m) != wanted:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0.2)


async def map_places(page: Page) -> MapPlaces:
    """Ask the map with the mouse where two of its pixels lie."""
    canvas = page.locator(".map-canvas canvas")
    await expect(canvas).to_be_visible()
    # It does so by itself once it is loaded, which may be after it was asked.
    await page.get_by_test_id("map-fit").click()
    box = await canvas.bounding_box()
    assert box is not None
    pixels = np.array([(box["width"] * share, box["height"] * share) for share in (_INSET, 1.0 - _INSET)]).round()
    world = []
    for x, y in pixels:
        world.append(mercator(await _place_under(page, box["x"] + x, box["y"] + y)))
    await page.mouse.move(0, 0)
    await expect(page.get_by_test_id("map-cursor")).to_be_empty()
    return MapPlaces(canvas, pixels - np.array((box["width"], box["height"])) / 2.0, np.array(world))


async def _place_under(page: Page, x: float, y: float) -> GeodeticPosition:
    """Return what the map says of a pixel, once it says the same twice: it may still be moving."""
    cursor = page.get_by_test_id("map-cursor")
    said = ""
    while True:
        await page.mouse.move(0, 0)
        await expect(cursor).to_be_empty()
        await page.mouse.move(x, y)
        await expect(cursor).to_contain_text("°")
        before, said = said, await cursor.inner_text()
        found = re.search(r"([\d.]+)° N, ([\d.]+)° E", said)
        if found is not None and said == before:
            return GeodeticPosition(float(found[1]), float(found[2]), 0.0)


async def show_only(page: Page, *layers: str, picture: str = "") -> None:
    """Show these layers of the map and a picture on the ground, if one is named, and nothing else."""
    await page.get_by_test_id("map-layers").click()
    await page.get_by_test_id("map-picture").select_option(picture)
    assert await page.evaluate(_SWITCH, [f"layer-{name}" for name in layers]) == []
    await page.get_by_test_id("map-layers").click()
    await page.evaluate(_DRAW)
