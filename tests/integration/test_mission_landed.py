"""What counts as landed, and that commands reach every vehicle that may fly, on a fake fleet in virtual time."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Hold, Land, LandedState
from tests.fakes.mission_flight import flying, prepare

pytestmark = pytest.mark.virtual


@pytest.mark.parametrize("reported", [LandedState.UNKNOWN, LandedState.IN_AIR])
@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND])
async def test_a_vehicle_that_seems_disarmed_in_the_air_is_commanded_down_with_the_others(
    action: Action, reported: LandedState
) -> None:
    """A reboot that never was: the motors seem to have stopped, and nothing is known about the ground."""
    flight = prepare(target=None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.armed, vehicle.reported_landed = False, reported
        await flight.clock.sleep(1.0)
        assert flight.task(2) is Task.SWARM
        await flight.clock.sleep(4.0)
        assert flight.task(2) is Task.HELD
        assert any("motors have stopped" in text for text in flight.texts())
        results = await flight.commands.act(action, None)
        assert all(result.accepted for result in results)
        vehicle.armed, vehicle.reported_landed = True, None
        await run
        assert flight.task(2) is Task.LANDED
    assert any(isinstance(command, Land) for command in vehicle.commands)


async def test_a_hold_reaches_a_vehicle_that_seems_disarmed() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.armed, vehicle.reported_landed = False, LandedState.UNKNOWN
        results = await flight.commands.act(Action.HOLD, None)
        assert {result.vehicle_id for result in results if result.accepted} == {1, 2, 3, 4}
        assert isinstance(vehicle.commands[-1], Hold)
        vehicle.armed, vehicle.reported_landed = True, None
        await flight.commands.act(Action.RETURN, None)
        await run


async def test_a_vehicle_that_is_airborne_counts_as_landed_no_more() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.PAUSE, None)
        vehicle = flight.fleet.members[2]
        vehicle.armed, vehicle.reported_landed = False, LandedState.ON_GROUND
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        vehicle.armed, vehicle.reported_landed, vehicle.mode = True, None, FlightMode.HOLD
        await flight.until(lambda: flight.task(2) is Task.HELD)
        await flight.commands.act(Action.RETURN, None)
        await run
        assert flight.task(2) is Task.LANDED
    assert "airborne again after its landing. Hold it, return it or land it" in flight.texts()
