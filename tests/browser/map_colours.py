"""What is drawn on the map: its canvas has no elements to ask for."""

from __future__ import annotations

import asyncio
import io

import numpy as np
from PIL import Image
from playwright.async_api import Page

from tests.browser.pages import TIMEOUT_MS

_NEAR = 40
"""Sum of the differences of red, green and blue, each up to 255: edges are smoothed."""
_POLL_S = 0.5
_FEW_PX = 5


async def wait_until_drawn(page: Page, colour: str) -> None:
    """Wait until a colour, ``#rrggbb``, is on the map."""
    async with asyncio.timeout(TIMEOUT_MS / 1000):
        while await _count_px(page, colour) < _FEW_PX:  # noqa: ASYNC110 - nothing announces it
            await asyncio.sleep(_POLL_S)


async def wait_until_gone(page: Page, colour: str) -> None:
    """Wait until a colour, ``#rrggbb``, is no longer on the map."""
    async with asyncio.timeout(TIMEOUT_MS / 1000):
        while await _count_px(page, colour) >= _FEW_PX:  # noqa: ASYNC110 - nothing announces it
            await asyncio.sleep(_POLL_S)


async def _count_px(page: Page, colour: str) -> int:
    png = await page.locator(".map-canvas canvas").screenshot()
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.int64)
    sought = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return int((np.abs(pixels - sought).sum(axis=-1) <= _NEAR).sum())
