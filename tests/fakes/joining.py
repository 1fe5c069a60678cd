"""Vehicles beside a mission in flight that may join it."""

from __future__ import annotations

import numpy as np

from aos_gcs.mission.model.actions import Action
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight


def switch_on(
    flight: Flight, vehicle_id: int, home_enu_m: tuple[float, float, float] = (20.0, -3.0, 0.0)
) -> FakeVehicle:
    """Let another vehicle be heard, on the ground."""
    vehicle = FakeVehicle(vehicle_id, flight.clock, np.array(home_enu_m), flight.fleet.members[1].target_enu_m)
    flight.fleet.members[vehicle_id] = vehicle
    return vehicle


async def heard(flight: Flight, vehicle_id: int) -> None:
    """Wait until a vehicle is part of the mission's state, and its settings have been read."""
    await flight.until(lambda: vehicle_id in {v.telemetry.vehicle_id for v in flight.view.snapshot().vehicles})
    await flight.clock.sleep(5.0)


async def paused(flight: Flight) -> None:
    """Pause the mission after its first step."""
    await flight.until(lambda: len(flight.view.steps()) == 1)
    await flight.commands.act(Action.PAUSE, None)
