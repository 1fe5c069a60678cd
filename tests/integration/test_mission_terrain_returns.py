"""Failsafe return heights over relief on a fake fleet, in virtual time: what preflight says, and what it sets."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rasterio")

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.settings import PreflightSettings
from tests.fakes.fleet import ORIGIN
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.relief import hill, terrain, write_relief

pytestmark = pytest.mark.virtual


def over_a_hill(folder: Path, *, sets_heights: bool = False) -> Flight:
    """Prepare a mission over a hill of 20 m that its layers of 35 m clear by 15 m; vehicles return at 30 m."""
    file = write_relief(folder / "ground.tif", hill(5.0, 40.0, 20.0), origin=ORIGIN)
    relief = terrain(file, floor_above_ground_m=14.0)
    return prepare(
        n=2,
        auto_start=False,
        terrain=relief,
        preflight=PreflightSettings(upload_fence=True, set_return_height=sets_heights),
    )


async def test_a_return_into_the_hill_fails_with_place_and_amount(tmp_path: Path) -> None:
    flight = over_a_hill(tmp_path)

    def found() -> list[PreflightCheck]:
        named = [check for check in flight.view.snapshot().preflight if check.name == checks.RETURN_HEIGHT]
        return [check for check in named if check.text.startswith("30 m, ")]

    async with flying(flight) as run:
        await flight.until(lambda: len(found()) == 2)
        for check in found():
            assert check.status is CheckStatus.FAIL
            assert "m below the floor above the ground at 48." in check.text
            assert "of the origin)" in check.text
            assert "(RTL_ALT) to between 3" in check.remedy
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_return_height_that_is_set_clears_the_hill(tmp_path: Path) -> None:
    flight = over_a_hill(tmp_path, sets_heights=True)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        await flight.commands.act(Action.ABORT, None)
        await run
