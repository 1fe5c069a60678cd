"""What a flying mission tells of its cameras and of the area that they have seen."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.steps import PictureKind
from tests.fakes.mission_flight import flying, prepare

pytestmark = pytest.mark.virtual


async def test_a_flying_mission_shows_footprints_legs_and_coverage() -> None:
    flight = prepare(3, target=None, pictures=True)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) >= 3)
        snapshot = flight.view.snapshot()
        await flight.commands.act(Action.ABORT, None)
        await run
    assert all(vehicle.camera and len(vehicle.camera.footprint_enu_m) == 4 for vehicle in snapshot.vehicles)
    assert 0.0 < (snapshot.covered_fraction or 0.0) <= 1.0
    assert len(snapshot.legs_enu_m) >= 1
    picture = flight.view.picture(PictureKind.COVERAGE)
    assert picture is not None
    recorded = {(picture.step, picture.kind) for picture in flight.recorder.pictures}
    assert {(1, kind) for kind in (PictureKind.INTEGRAL, PictureKind.COVERAGE)} <= recorded
