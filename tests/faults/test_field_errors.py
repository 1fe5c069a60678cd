"""A mission of vehicles and cameras that err as in the field: attitudes, gimbals, shutters, wind, sensors."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.vehicles import Task
from aos_sim.errors.model import RTK
from tests.fakes.air import Air
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_vehicles_that_err_as_in_the_field_search_and_land(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    async with flying_over(monkeypatch, Air(), autopilot=autopilot, errors=RTK.with_wind(6.0)) as flight:
        await flight.until_step(3)
        await flight.run
        flight.assert_nobody_was_endangered()
        assert {vehicle_id: flight.task(vehicle_id) for vehicle_id in (1, 2, 3)} == dict.fromkeys(
            (1, 2, 3), Task.LANDED
        )
