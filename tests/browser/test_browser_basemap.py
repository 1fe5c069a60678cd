"""The map on a base map of the service, in a real browser."""

from __future__ import annotations

import asyncio
import gzip
import io
import struct
from functools import partial
from pathlib import Path

import pytest
from PIL import Image
from playwright.async_api import FloatRect, Page, expect

from aos_gcs.api.app import create_app
from tests.browser.conftest import serving
from tests.browser.pages import open_page

pytestmark = pytest.mark.asyncio(loop_scope="session")

ORANGE = (230, 120, 20)
DRAWING_TIMEOUT_S = 60.0
_HEADER_LENGTH = 127
_TILE_TYPE_PNG = 2
_GZIP, _UNCOMPRESSED = 2, 1


def pmtiles_of(tile_png: bytes) -> bytes:
    """Return a PMTiles archive (version 3) of the one tile that covers the world."""
    # One entry: tile id 0, run length 1, its length, and offset 0 stored as 1; all as varints.
    length = bytes([len(tile_png) & 0x7F | 0x80, len(tile_png) >> 7])
    root = gzip.compress(bytes([1, 0, 1]) + length + bytes([1]))
    metadata = gzip.compress(b"{}")
    offsets = [_HEADER_LENGTH, _HEADER_LENGTH + len(root)]
    tiles_at = offsets[1] + len(metadata)
    header = struct.pack("<7sB", b"PMTiles", 3)
    header += struct.pack("<8Q", offsets[0], len(root), offsets[1], len(metadata), 0, 0, tiles_at, len(tile_png))
    header += struct.pack("<3Q", 1, 1, 1)
    header += struct.pack("<6B", 1, _GZIP, _UNCOMPRESSED, _TILE_TYPE_PNG, 0, 0)
    header += struct.pack("<4iB2i", -1800000000, -850000000, 1800000000, 850000000, 0, 0, 0)
    return header + root + metadata + tile_png


async def test_the_map_lies_on_the_services_base_map(map_page: Page, tmp_path: Path, page_record) -> None:
    tile = io.BytesIO()
    Image.new("RGB", (256, 256), ORANGE).save(tile, "PNG")
    file = tmp_path / "orange.pmtiles"
    file.write_bytes(pmtiles_of(tile.getvalue()))
    async with serving(partial(create_app, basemap_file=file)) as service:
        async with map_page.expect_response(lambda response: response.url.endswith(".pmtiles")) as answered:
            await open_page(map_page, service.url)
        assert (await answered.value).status == 206
        canvas = map_page.locator(".map-canvas canvas")
        await expect(canvas).to_be_visible()
        box = await canvas.bounding_box()
        assert box is not None
        right, bottom = box["x"] + box["width"], box["y"] + box["height"]
        corner: FloatRect = {"x": right - 60, "y": bottom - 60, "width": 40, "height": 40}
        async with asyncio.timeout(DRAWING_TIMEOUT_S):
            while await commonest_colour(map_page, corner) != ORANGE:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0.2)
        assert page_record.errors == []


async def commonest_colour(page: Page, clip: FloatRect) -> object:
    """Return the colour of most pixels of a part of the screen."""
    shot = Image.open(io.BytesIO(await page.screenshot(clip=clip))).convert("RGB")
    colours = shot.getcolors(shot.width * shot.height)
    return max(colours)[1] if colours else None
