"""Missions of vehicles and cameras that err as in the field: attitudes, gimbals, shutters, wind, sensors."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_sim.errors.model import RTK
from aos_sim.vehicle.arducopter import ArduCopter
from aos_sim.vehicle.vehicle import SimulatedVehicle
from tests.fakes.air import Air, Faults
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.virtual, pytest.mark.timeout(900)]

ALL_LANDED = dict.fromkeys((1, 2, 3), Task.LANDED)


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_vehicles_that_err_as_in_the_field_search_and_land(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    async with flying_over(monkeypatch, Air(), autopilot=autopilot, errors=RTK.with_wind(6.0)) as flight:
        await flight.until_step(3)
        await flight.run
        flight.assert_nobody_was_endangered()
        assert {vehicle_id: flight.task(vehicle_id) for vehicle_id in (1, 2, 3)} == ALL_LANDED


async def test_a_vehicle_that_reboots_in_flight_falls_alone_and_the_others_find_the_person(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with flying_over(monkeypatch, Air(), errors=RTK) as flight:
        await flight.until_step(2)
        old = flight.swarm.vehicle(2)
        flight.swarm.vehicles[1] = SimulatedVehicle(
            ArduCopter(old.autopilot.identity, flight.swarm.kinematics(2)), old.camera
        )
        assert await flight.run is Outcome.FOUND
        flight.assert_nobody_was_endangered()
        assert any("motors have stopped" in text for text in flight.texts())
        assert {vehicle_id: flight.task(vehicle_id) for vehicle_id in (1, 2, 3)} == ALL_LANDED


async def test_a_person_is_found_over_a_bad_radio_link(monkeypatch: pytest.MonkeyPatch) -> None:
    faults = Faults(loss=0.1, duplicate=0.1, reorder=0.1, latency_s=0.25, corrupt=0.02)
    patience = {"FS_GCS_TIMEOUT": 60.0}
    async with flying_over(monkeypatch, Air(faults), vehicles=2, parameters=patience, errors=RTK) as flight:
        assert await flight.run is Outcome.FOUND
        assert flight.swarm.report().landed == 2
        flight.assert_nobody_was_endangered()
