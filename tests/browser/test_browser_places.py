"""What lies on the map lies at its true place: measured on the screen, in pixels."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
import pytest_asyncio
from playwright.async_api import Locator, Page

from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.findings import ErrorEllipse
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.mission.model.vehicles import CameraSnapshot
from tests.browser.conftest import PageRecord
from tests.browser.map_places import DRAWING_TIMEOUT_S, MapPlaces, map_places, show_only
from tests.browser.pages import open_page
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

pytestmark = [pytest.mark.asyncio(loop_scope="session"), pytest.mark.slow]

STEPS = 12
ELLIPSE = ErrorEllipse(semi_major_m=48.0, semi_minor_m=34.0, heading_rad=math.radians(60.0))
"""Size at which its label lies inside."""
FOOTPRINT_ENU_M = ((-40.0, 60.0), (-5.0, 75.0), (25.0, 20.0), (-30.0, 5.0))
COVERED_SHARE = 0.48
"""Radius of what a scripted picture covers, as a share of its width."""
TOLERANCE_PX = 2.0
"""A line's width, and a pixel of the picture."""
LEAST_CHANGE = 6
"""Difference of a colour's parts, out of 255."""


class StillMission(ScriptedMission):
    """Stands where it is after some steps, with a target that is known badly, and one camera that sees something."""

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        told = super().snapshot()
        first, *others = told.vehicles
        return replace(
            told,
            targets=tuple(replace(target, ellipse=ELLIPSE) for target in told.targets),
            vehicles=(replace(first, camera=CameraSnapshot(STEPS, 0, STEPS, FOOTPRINT_ENU_M)), *others),
        )


@pytest_asyncio.fixture(loop_scope="session")
async def mission(dashboard_build: None) -> AsyncIterator[tuple[StillMission, str]]:  # noqa: ARG001 - asked for its check
    mission = StillMission(LoopClock())
    for _ in range(STEPS):
        mission.make_step()
    mission.phase = Phase.DONE
    async with serve(app_of(mission), port=0) as address:
        running = asyncio.create_task(mission.run())
        yield mission, address.url
        running.cancel()


async def changed_box(page: Page, places: MapPlaces, layers: Sequence[str], picture: str) -> np.ndarray:
    """Return left, top, right and bottom of what a layer or a picture changes on the canvas, in pixels.

    A layer's legend lies above the canvas and is no change of it.
    """
    await show_only(page)
    without = (await places.picture()).astype(int)
    await show_only(page, *layers, picture=picture)
    legends = [await _box_on_canvas(places, legend) for legend in await page.locator(".map-legend").all()]
    before = None
    async with asyncio.timeout(DRAWING_TIMEOUT_S):
        while True:
            changed = np.abs((await places.picture()).astype(int) - without).max(axis=2) >= LEAST_CHANGE
            for left, top, right, bottom in legends:
                changed[top:bottom, left:right] = False
            if before is not None and changed.any() and np.array_equal(changed, before):
                break
            before = changed
            await asyncio.sleep(0.3)
    rows, columns = np.nonzero(changed)
    return np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1])


async def _box_on_canvas(places: MapPlaces, element: Locator) -> tuple[int, int, int, int]:
    canvas, box = await places.canvas.bounding_box(), await element.bounding_box()
    assert canvas is not None
    assert box is not None
    left, top = math.floor(box["x"] - canvas["x"]), math.floor(box["y"] - canvas["y"])
    return left, top, left + math.ceil(box["width"]) + 1, top + math.ceil(box["height"]) + 1


async def box_of(places: MapPlaces, west_m: float, south_m: float, east_m: float, north_m: float) -> np.ndarray:
    """Return where a box on the ground lies on the canvas."""
    picture = await places.picture()
    return np.array([*places.pixel(west_m, north_m, picture), *places.pixel(east_m, south_m, picture)])


async def test_pictures_footprints_and_ellipses_lie_at_their_true_places(
    map_page: Page, mission: tuple[StillMission, str], page_record: PageRecord
) -> None:
    still, url = mission
    await open_page(map_page, url)
    places = await map_places(map_page)

    picture = still.picture(PictureKind.INTEGRAL)
    assert picture is not None
    east_m, north_m = (picture.west_m + picture.east_m) / 2, (picture.south_m + picture.north_m) / 2
    radius_m = COVERED_SHARE * (picture.east_m - picture.west_m)
    covered = await box_of(places, east_m - radius_m, north_m - radius_m, east_m + radius_m, north_m + radius_m)
    for kind in ("integral", "coverage", "visibility", "floor"):
        box = await changed_box(map_page, places, [], kind)
        np.testing.assert_allclose(box, covered, atol=TOLERANCE_PX, err_msg=kind)

    box = await changed_box(map_page, places, ["searched"], "")
    np.testing.assert_allclose(box, covered, atol=TOLERANCE_PX, err_msg="searched ground")

    corners = np.array(FOOTPRINT_ENU_M)
    expected = await box_of(places, *corners.min(axis=0), *corners.max(axis=0))
    box = await changed_box(map_page, places, ["footprints"], "")
    np.testing.assert_allclose(box, expected, atol=TOLERANCE_PX, err_msg="footprints")

    (target,) = still.snapshot().targets
    east_m, north_m, _ = target.position_enu_m
    a, b, heading = ELLIPSE.semi_major_m, ELLIPSE.semi_minor_m, ELLIPSE.heading_rad
    reach_east_m = math.hypot(a * math.sin(heading), b * math.cos(heading))
    reach_north_m = math.hypot(a * math.cos(heading), b * math.sin(heading))
    expected = await box_of(
        places, east_m - reach_east_m, north_m - reach_north_m, east_m + reach_east_m, north_m + reach_north_m
    )
    box = await changed_box(map_page, places, ["targets"], "")
    np.testing.assert_allclose(box, expected, atol=TOLERANCE_PX, err_msg="ellipse")
    assert page_record.errors == []
