"""The map on a base map of the service, in a real browser: pictures and vectors, and nothing from elsewhere."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest
from PIL import Image
from playwright.async_api import Page, expect

from aos_gcs.api.app import create_app
from tests.browser.conftest import PageRecord, serving
from tests.browser.map_places import map_places, place, show_only
from tests.browser.pages import open_page
from tests.fakes.app import app_of
from tests.fakes.relief import terrain, write_relief
from tests.fakes.scripted_vehicle import ORIGIN
from tests.fakes.tiles import MVT, PNG, Shape, pmtiles, tile_at, vector_tile

pytestmark = pytest.mark.asyncio(loop_scope="session")

ORANGE = "#e67814"
BACKGROUND = "#f3f5f2"
"""Colour of the map in the light theme, where nothing lies on it."""
PALETTE_FILE = Path(__file__).resolve().parents[2] / "web/src/map/palette.ts"
ZOOM = 14


@dataclass(frozen=True, slots=True)
class Names:
    """What a schema calls its layers, and what its features are."""

    wood: str
    streams: str
    buildings: str
    roads: str
    contours: str
    kind: str


PROTOMAPS = Names("landuse", "water", "buildings", "roads", "contours", "kind")
OPENMAPTILES = Names("landcover", "waterway", "building", "transportation", "contour", "class")


def ground_colours(theme: str) -> dict[str, str]:
    """Return the page's own colours of a base map in vectors."""
    found = re.search(rf"\b{theme}: {{.*?ground: {{(.*?)}}", PALETTE_FILE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return dict(re.findall(r'(\w+): "(#\w{6})"', found[1]))


def box(west_m: float, south_m: float, east_m: float, north_m: float, **properties: str) -> Shape:
    """Return an area on the ground."""
    corners = [(west_m, north_m), (east_m, north_m), (east_m, south_m), (west_m, south_m)]
    return Shape([place(*corner) for corner in corners], is_area=True, properties=properties)


def line(west_m: float, east_m: float, north_m: float, **properties: str) -> Shape:
    """Return a line from west to east."""
    return Shape([place(west_m, north_m), place(east_m, north_m)], is_area=False, properties=properties)


async def test_the_map_lies_on_pictures(map_page: Page, tmp_path: Path, page_record: PageRecord) -> None:
    tile = io.BytesIO()
    Image.new("RGB", (256, 256), ORANGE).save(tile, "PNG")
    file = tmp_path / "orange.pmtiles"
    file.write_bytes(pmtiles(tile.getvalue(), PNG))
    async with serving(partial(app_of, basemap_file=file)) as service:
        async with map_page.expect_response(lambda response: response.url.endswith(".pmtiles")) as answered:
            await open_page(map_page, service.url)
        assert (await answered.value).status == 206
        places = await map_places(map_page)
        await show_only(map_page, "basemap")
        await places.await_colour(20.0, 40.0, ORANGE)
        assert page_record.errors == []


async def test_a_map_is_chosen_or_dropped_in_the_browser_and_others_are_refused(
    map_page: Page, page_record: PageRecord
) -> None:
    tile = io.BytesIO()
    Image.new("RGB", (256, 256), ORANGE).save(tile, "PNG")
    archive = pmtiles(tile.getvalue(), PNG, attribution='<a href="javascript:alert(1)">© A team</a><img src=x>')
    async with serving() as service:
        await open_page(map_page, service.url)
        places = await map_places(map_page)
        await show_only(map_page, "basemap")
        background = "#" + bytes(await places.colour(20.0, 40.0)).hex()
        layers = map_page.get_by_test_id("map-layers")
        await layers.click()
        chooser, refusal = map_page.get_by_test_id("basemap-file"), map_page.get_by_test_id("basemap-refusal")
        for name, content in (("notes.pmtiles", b"no map"), ("cut.pmtiles", archive[:-1])):
            await chooser.set_input_files({"name": name, "mimeType": "", "buffer": content})
            await expect(refusal).to_contain_text(f"{name} is not a complete PMTiles file")
        await chooser.set_input_files({"name": "team.pmtiles", "mimeType": "", "buffer": archive})
        await expect(refusal).to_be_empty()
        await layers.click()
        await places.await_colour(20.0, 40.0, ORANGE)
        attribution = map_page.get_by_test_id("map-attribution")
        assert await attribution.inner_html() == "© A team"
        await layers.click()
        await map_page.get_by_test_id("basemap-forget").click()
        await expect(attribution).to_be_hidden()
        await expect(map_page.get_by_test_id("basemap-forget")).to_be_hidden()
        await layers.click()
        await places.await_colour(20.0, 40.0, background)
        await map_page.evaluate(
            """([bytes]) => {
              const files = new DataTransfer();
              files.items.add(new File([new Uint8Array(bytes)], "dropped.pmtiles"));
              const dropped = new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true });
              document.querySelector("[data-testid=map]").dispatchEvent(dropped);
            }""",
            [list(archive)],
        )
        await places.await_colour(20.0, 40.0, ORANGE)
        await layers.click()
        await expect(map_page.get_by_test_id("basemap-forget")).to_contain_text("dropped.pmtiles")
        assert page_record.foreign_requests == []


@pytest.mark.parametrize(
    "names",
    [
        pytest.param(PROTOMAPS, id="protomaps"),
        pytest.param(OPENMAPTILES, id="openmaptiles", marks=pytest.mark.slow),
    ],
)
async def test_the_map_lies_on_vectors_at_their_true_places(
    map_page: Page, tmp_path: Path, page_record: PageRecord, names: Names
) -> None:
    layers: dict[str, list[Shape]] = {
        "water": [box(10.0, 65.0, 30.0, 85.0)],
        names.wood: [
            box(10.0, 30.0, 30.0, 50.0, **{names.kind: "forest"}),
            box(40.0, 30.0, 58.0, 50.0, **{names.kind: "industrial"}),
        ],
        names.buildings: [box(40.0, 65.0, 55.0, 80.0)],
        names.roads: [line(5.0, 58.0, 10.0, **{names.kind: "motorway"})],
        names.contours: [line(5.0, 58.0, -5.0, ele="300")],
    }
    layers.setdefault(names.streams, []).append(line(5.0, 58.0, 57.5))
    tile = tile_at(place(30.0, 40.0), ZOOM)
    file = tmp_path / "ground.pmtiles"
    file.write_bytes(pmtiles(vector_tile(tile, layers), MVT, tile, list(layers)))
    colours = ground_colours("light")
    async with serving(partial(app_of, basemap_file=file)) as service:
        await open_page(map_page, service.url)
        places = await map_places(map_page)
        await show_only(map_page, "basemap")
        background = await places.colour(-30.0, 40.0)
        await places.await_colour(20.0, 75.0, colours["water"])
        await places.await_colour(20.0, 40.0, colours["wood"])
        await places.await_colour(47.5, 72.5, colours["building"])
        await places.await_colour(30.0, 10.0, colours["road"])
        await places.await_line(30.0, 57.5, background)  # a stream
        await places.await_line(10.0, -5.0, background)  # a contour line
        assert await places.colour(49.0, 40.0) == background  # no wood
        # A metre inside and outside of the water's rims.
        for inside, outside in [((11, 75), (9, 75)), ((29, 75), (31, 75)), ((20, 66), (20, 64)), ((20, 84), (20, 86))]:
            await places.await_colour(*inside, colours["water"])
            assert await places.colour(*outside) == background
        assert page_record.errors == []
        assert page_record.foreign_requests == []


async def test_contour_lines_and_shading_lie_where_the_ground_has_their_height(
    map_page: Page, tmp_path: Path, page_record: PageRecord
) -> None:
    """Draws a line every 25 m over a slope of 4 %, at whose foot in the south the origin lies 262 m above the sea."""
    pytest.importorskip("rasterio")
    ground = terrain(write_relief(tmp_path / "slope.tif", lambda _, north: 0.04 * north, origin=ORIGIN))
    async with serving(partial(create_app, terrain=ground)) as service:
        await open_page(map_page, service.url)
        places = await map_places(map_page)
        layers = map_page.get_by_test_id("map-layers")
        # Both are shown from the moment at which the station has told of them, which may be long after the page is.
        await layers.click()
        await expect(map_page.get_by_test_id("layer-shading")).to_be_visible()
        await layers.click()
        await show_only(map_page)
        await places.await_colour(-30.0, 50.0, BACKGROUND)
        background = await places.colour(-30.0, 50.0)
        await layers.click()
        switch = map_page.get_by_test_id("layer-contours")
        await switch.check()
        await layers.click()
        for north_m in (25.0, 50.0):
            await places.await_line(-40.0, north_m, background)
            assert await places.colour(-40.0, north_m + 12.5) == background
        await layers.click()
        await switch.uncheck()
        await map_page.get_by_test_id("layer-shading").check()
        await layers.click()
        await places.await_line(-30.0, 50.0, background)  # ground that falls towards the south lies in the shade
        assert page_record.errors == []
