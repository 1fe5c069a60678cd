"""Vehicles on their way down that would hover with nothing commanded; a fake fleet in virtual time."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, DetectionSettings
from aos_gcs.ports import FlightMode, Goto, Hold, Land
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

LOW = 0.15
REPEATED = "has not begun to land: it is told again until it does"


def long_search() -> Flight:
    deadlines = Deadlines(connect_s=5.0, preflight_s=15.0, capture_s=5.0, transfer_s=60.0, land_s=60.0)
    return prepare(4, None, detection=DetectionSettings(), deadlines=deadlines)


async def pause(flight: Flight) -> FakeVehicle:
    """Pause in the middle of the search, and return vehicle 2."""
    await flight.until(lambda: len(flight.view.steps()) == 1)
    await flight.commands.act(Action.PAUSE, None)
    await flight.clock.sleep(3.0)
    return flight.fleet.members[2]


async def test_a_landing_that_a_vehicle_refuses_is_repeated_and_reported_once() -> None:
    flight = long_search()
    async with flying(flight) as run:
        vehicle = await pause(flight)
        vehicle.refuses, vehicle.battery_fraction = frozenset({Land}), LOW
        await flight.until(lambda: flight.task(2) is Task.LANDING)
        await flight.clock.sleep(21.0)
        assert 4 <= vehicle.commands.count(Land()) <= 6
        assert sum("Land denied" in text for text in flight.texts()) == 1
        assert flight.texts().count(REPEATED) == 1
        vehicle.refuses = frozenset()
        await flight.clock.sleep(12.0)
        assert flight.task(2) is Task.LANDED
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_landing_that_was_lost_with_the_link_is_repeated() -> None:
    flight = long_search()
    async with flying(flight) as run:
        vehicle = await pause(flight)
        execute = vehicle.execute

        async def unheard(command: object, deadline_s: float) -> None:
            if isinstance(command, Land):
                vehicle.silent_since_s = flight.clock.now_s()
            await execute(command, deadline_s)  # type: ignore[arg-type]

        vehicle.execute = unheard  # type: ignore[method-assign, assignment]
        vehicle.battery_fraction = LOW
        await flight.until(lambda: flight.task(2) is Task.LOST)
        await flight.clock.sleep(7.0)
        vehicle.execute = execute  # type: ignore[method-assign]
        vehicle.silent_since_s = None
        assert vehicle.mode is FlightMode.GUIDED
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_that_an_operator_holds_on_its_way_down_is_not_landed_before_its_battery_is_low() -> None:
    flight = long_search()
    async with flying(flight) as run:
        vehicle = await pause(flight)
        await flight.commands.act(Action.LAND, (2,))
        await flight.clock.sleep(1.0)
        await flight.commands.act(Action.HOLD, None)
        held = len(vehicle.commands)
        await flight.clock.sleep(60.0)
        assert (flight.task(2), vehicle.commands[held:]) == (Task.LANDING, [])
        vehicle.battery_fraction = LOW
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        assert vehicle.commands[held:] == [Land()]
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_hold_of_all_does_not_outlast_the_battery_of_a_vehicle_that_returns() -> None:
    flight = long_search()
    async with flying(flight) as run:
        vehicle = await pause(flight)
        vehicle.battery_fraction = LOW
        await flight.until(lambda: isinstance(vehicle.commands[-1], Goto) and flight.task(2) is Task.RETURNING)
        await flight.clock.sleep(0.3)
        await flight.commands.act(Action.HOLD, None)
        assert isinstance(vehicle.commands[-1], Hold)
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        others = [other for number, other in flight.fleet.members.items() if number != 2]
        assert all(isinstance(other.commands[-1], Hold) for other in others)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_hold_of_all_on_the_way_home_ends_for_each_vehicle_whose_battery_runs_low() -> None:
    flight = long_search()
    async with flying(flight) as run:
        vehicle = await pause(flight)
        await flight.commands.act(Action.RETURN, None)
        await flight.clock.sleep(0.3)
        await flight.commands.act(Action.HOLD, None)
        await flight.clock.sleep(30.0)
        assert flight.mission.phase is Phase.RETURN
        assert all(isinstance(other.commands[-1], Hold) for other in flight.fleet.members.values())
        vehicle.battery_fraction = LOW
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        assert flight.task(1) is Task.RETURNING
        await flight.commands.act(Action.RESUME, None)
        await run
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4
