"""What goes wrong, and what an operator does at the worst moment, on a fake fleet in virtual time."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from aos_gcs.mission.model import Action
from aos_gcs.ports import (
    Capture,
    FlightMode,
    Hold,
    Land,
    ReturnToLaunch,
)
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.looptime


def slow_cameras(flight: Flight, duration_s: float = 4.0) -> None:
    """Let every exposure take a while, as most of a real step does."""
    for vehicle in flight.fleet.members.values():
        take = vehicle.capture

        async def capture(deadline_s: float, take: Callable = take) -> Capture:
            await flight.clock.sleep(duration_s)
            return await take(deadline_s)

        vehicle.capture = capture  # type: ignore[method-assign]


async def in_a_capture(flight: Flight) -> None:
    """Wait until the cameras of the second step are exposing."""
    await flight.until(lambda: len(flight.mission.steps()) == 1)
    await flight.until(lambda: flight.mission.snapshot().message == "Step 2: taking frames.")
    await flight.clock.sleep(1.0)


# --- whoever leaves the swarm in the middle of a step ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "command"), [(Action.HOLD, Hold), (Action.RETURN, ReturnToLaunch), (Action.LAND, Land)]
)
async def test_a_step_in_hand_does_not_command_who_left_meanwhile(action: Action, command: type) -> None:
    flight = prepare()
    slow_cameras(flight)
    async with flying(flight) as run:
        await in_a_capture(flight)
        await flight.mission.act(action, (1,))
        await flight.until(lambda: len(flight.mission.steps()) == 3)
        assert isinstance(flight.fleet.members[1].commands[-1], command)
        record = {record.vehicle_id: record for record in flight.mission.steps()[1].waypoints}[1]
        assert record.sent_enu_m is None
        assert "left the swarm" in record.reason
        await flight.mission.act(Action.ABORT, None)
        await run


async def test_a_step_in_hand_does_not_wrest_a_vehicle_from_its_pilot() -> None:
    flight = prepare()
    slow_cameras(flight)
    async with flying(flight) as run:
        await in_a_capture(flight)
        vehicle = flight.fleet.members[2]
        vehicle.mode, commands = FlightMode.MANUAL, len(vehicle.commands)
        await flight.until(lambda: len(flight.mission.steps()) == 4)
        assert vehicle.commands[commands:] == []
        vehicle.mode = FlightMode.HOLD
        (result,) = await flight.mission.act(Action.RESUME, (2,))
        assert result.accepted
        await flight.until(lambda: len(flight.mission.steps()) == 6)
        assert 2 in flight.mission.steps()[-1].fitness
        await flight.mission.act(Action.ABORT, None)
        await run
