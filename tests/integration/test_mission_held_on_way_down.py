"""Vehicles that an operator holds while all return or land; a fake fleet in virtual time."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold, Land, ReturnToLaunch
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

WAITED_FOR = "hovers, as an operator has ordered: resume, return or land it"


async def held_on_the_way_home(flight: Flight) -> FakeVehicle:
    """Return all, hold vehicle 2 on its way, and wait until the others have landed."""
    await flight.until(lambda: len(flight.view.steps()) == 2)
    await flight.commands.act(Action.RETURN, None)
    await flight.clock.sleep(0.6)
    assert flight.mission.phase is Phase.RETURN
    await flight.commands.act(Action.HOLD, (2,), operator="Ada")
    await others_have_landed(flight)
    return flight.fleet.members[2]


async def held_while_all_land(flight: Flight) -> FakeVehicle:
    """Land all, hold vehicle 2 on its way down, and wait until the others have landed."""
    await flight.until(lambda: len(flight.view.steps()) == 2)
    vehicle = flight.fleet.members[2]
    await flight.commands.act(Action.LAND, None)
    await flight.until(lambda: vehicle.commands[-1] == Land())
    await flight.clock.sleep(1.0)
    await flight.commands.act(Action.HOLD, (2,), operator="Ada")
    await others_have_landed(flight)
    return vehicle


async def others_have_landed(flight: Flight) -> None:
    await flight.until(lambda: all(flight.task(number) is Task.LANDED for number in (1, 3, 4)))
    await flight.clock.sleep(100.0)  # longer than a landing may take


def from_home_m(vehicle: FakeVehicle) -> float:
    return math.dist(vehicle.position_enu_m()[:2], vehicle.home_enu_m[:2])


@pytest.mark.parametrize("bring_down", [held_on_the_way_home, held_while_all_land])
async def test_a_hold_of_one_vehicle_lasts_while_the_others_come_down_and_is_reported(
    bring_down: Callable[[Flight], Awaitable[FakeVehicle]],
) -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await bring_down(flight)
        assert flight.task(2) is Task.HELD
        assert isinstance(vehicle.commands[-1], Hold)
        assert flight.mission.phase is Phase.LAND, "the mission is not over while somebody has to decide"
        assert flight.view.snapshot().message == "Landing: waiting for vehicle 2."
        assert flight.texts().count(WAITED_FOR) == 1
        vehicle.battery_fraction = 0.1
        await run
    assert from_home_m(vehicle) < 0.6, "its battery ends the hold"
    assert flight.task(2) is Task.LANDED


async def test_a_vehicle_held_on_its_way_home_flies_home_when_it_is_resumed() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await held_on_the_way_home(flight)
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert (result.accepted, result.text) == (True, "returns to its launch point")
        await run
    assert from_home_m(vehicle) < 0.6
    assert ReturnToLaunch() not in vehicle.commands, "it was led home"
    assert flight.task(2) is Task.LANDED


async def test_a_vehicle_held_while_all_land_lands_where_it_is_when_it_is_resumed() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await held_while_all_land(flight)
        place_m = vehicle.position_enu_m()[:2]
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert (result.accepted, result.text) == (True, "lands where it is")
        await run
    assert math.dist(vehicle.position_enu_m()[:2], place_m) < 0.1
    assert flight.task(2) is Task.LANDED


@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND])
async def test_a_newer_order_for_all_ends_the_hold_of_one_vehicle(action: Action) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        await flight.commands.act(Action.RETURN, None)
        await flight.clock.sleep(0.6)
        await flight.commands.act(Action.HOLD, (2,))
        await flight.clock.sleep(0.2)
        await flight.commands.act(action, None)
        await run
    assert (from_home_m(vehicle) < 0.6) is (action is Action.RETURN)
    assert flight.task(2) is Task.LANDED


async def test_a_hold_of_all_and_a_resumption_take_a_vehicle_that_was_held_alone_home() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await held_on_the_way_home(flight)
        await flight.commands.act(Action.HOLD, None)
        await flight.clock.sleep(2.0)
        await flight.commands.act(Action.RESUME, None)
        await run
    assert from_home_m(vehicle) < 0.6
    assert flight.task(2) is Task.LANDED


async def test_a_vehicle_that_was_held_before_all_return_comes_home_with_them() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.HOLD, (2,))
        await flight.commands.act(Action.RETURN, None)
        await run
    assert from_home_m(flight.fleet.members[2]) < 0.6
