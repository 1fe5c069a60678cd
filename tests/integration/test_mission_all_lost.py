"""All links out for some time: the mission ends, and what is heard again is led home; a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
import math

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Command, Goto, Hold, Land, LandedState, ReturnToLaunch
from tests.fakes.mission_flight import Flight, flying, lose, prepare

pytestmark = pytest.mark.virtual

NUMBERS = (1, 2, 3, 4)
AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 170.0), (-12.0, 170.0))


async def lose_all(flight: Flight, for_s: float) -> None:
    """End the mission by a silence of all vehicles, whose failsafes wait for longer, and let them be heard again."""
    began_s = flight.clock.now_s()
    for vehicle in flight.fleet.members.values():
        lose(vehicle)
    await flight.until(lambda: flight.mission.phase is Phase.DONE)
    await flight.clock.sleep(for_s - (flight.clock.now_s() - began_s))


def let_be_heard(flight: Flight) -> None:
    for vehicle in flight.fleet.members.values():
        vehicle.silent_since_s = None


def from_home_m(flight: Flight, number: int) -> float:
    vehicle = flight.fleet.members[number]
    return math.dist(vehicle.position_enu_m()[:2], vehicle.home_enu_m[:2])


@pytest.mark.parametrize("phase", [Phase.SCAN, Phase.RETURN])
async def test_vehicles_heard_again_after_the_end_are_led_home(phase: Phase) -> None:
    flight = prepare(4, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        if phase is Phase.RETURN:
            await flight.commands.act(Action.RETURN, None)
            await flight.clock.sleep(0.3)
        await lose_all(flight, 23.0)
        assert await run is Outcome.FAILED
        staying = asyncio.create_task(flight.mission.stay(until_landed=True))
        let_be_heard(flight)
        await flight.clock.sleep(4.0)
        assert not any("goes on in the swarm" in text for text in flight.texts())
        assert not any(flight.task(number) is Task.SWARM for number in NUMBERS)
        async with flight.clock.timeout_at(flight.clock.now_s() + 120.0):
            await staying
    assert [flight.task(number) for number in NUMBERS] == [Task.LANDED] * 4
    assert max(from_home_m(flight, number) for number in NUMBERS) < 0.6
    vehicles = flight.fleet.members.values()
    assert not any(ReturnToLaunch() in vehicle.commands for vehicle in vehicles), "in their layers"


async def test_it_goes_on_until_the_motors_of_the_last_vehicle_have_stopped() -> None:
    """Autopilots stop their motors up to seconds after they report that they are on the ground."""
    flight = prepare(4, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await lose_all(flight, 23.0)
        await run
        staying = asyncio.create_task(flight.mission.stay(until_landed=True))
        let_be_heard(flight)
        await flight.until(lambda: all(flight.task(number) is Task.LANDING for number in NUMBERS))
        for vehicle in flight.fleet.members.values():
            vehicle.reported_landed = LandedState.ON_GROUND
        assert all(vehicle.armed for vehicle in flight.fleet.members.values())
        await staying
        shown = flight.view.snapshot().vehicles
    assert [(vehicle.task, vehicle.telemetry.armed) for vehicle in shown] == [(Task.LANDED, False)] * 4


async def test_a_vehicle_that_an_operator_held_before_is_left_there_and_named() -> None:
    flight = prepare(4, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.HOLD, (2,))
        await lose_all(flight, 23.0)
        await run
        staying = asyncio.create_task(flight.mission.stay(until_landed=True))
        let_be_heard(flight)
        await flight.clock.sleep(90.0)
        assert [flight.task(number) for number in NUMBERS] == [Task.LANDED, Task.HELD, Task.LANDED, Task.LANDED]
        assert isinstance(flight.fleet.members[2].commands[-1], Hold)
        assert any("it hovers, as an operator has ordered, and the mission is over" in text for text in flight.texts())
        await flight.commands.act(Action.LAND, (2,))
        await staying
    assert flight.task(2) is Task.LANDED


@pytest.mark.parametrize("action", [Action.LAND, Action.RETURN])
async def test_an_order_of_an_operator_after_the_end_is_not_superseded_by_the_way_home(action: Action) -> None:
    flight = prepare(4, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        await lose_all(flight, 23.0)
        await run
        staying = asyncio.create_task(flight.mission.stay(until_landed=True))
        let_be_heard(flight)
        await flight.until(lambda: isinstance(vehicle.commands[-1], Goto) and flight.task(2) is Task.RETURNING)
        await flight.clock.sleep(0.3)
        execute, told = vehicle.execute, len(vehicle.commands)

        async def slowly(command: Command, deadline_s: float) -> None:
            await flight.clock.sleep(2.0)  # its mode shows the order only then
            await execute(command, deadline_s)

        vehicle.execute = slowly  # type: ignore[method-assign]
        (result,) = await flight.commands.act(action, (2,))
        assert result.accepted
        await staying
    assert vehicle.commands[told:] == [Land() if action is Action.LAND else ReturnToLaunch()]
    assert flight.task(2) is Task.LANDED


async def test_a_vehicle_that_a_pilot_has_taken_over_meanwhile_is_left_alone() -> None:
    flight = prepare(4, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        await lose_all(flight, 23.0)
        await run
        staying = asyncio.create_task(flight.mission.stay(until_landed=True))
        vehicle.taken_over, vehicle.has_pilot, told = "its mode changed to LOITER", True, len(vehicle.commands)
        let_be_heard(flight)
        await flight.clock.sleep(60.0)
        assert vehicle.commands[told:] == []
        staying.cancel()


async def test_a_station_without_a_page_waits_for_lost_vehicles_until_their_failsafes_have_acted() -> None:
    flight = prepare(4, None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        lost_s = flight.clock.now_s()
        await lose_all(flight, 21.0)
        await run
        assert flight.mission.may_any_fly
        assert not flight.mission.is_any_flying
        await flight.mission.stay(until_landed=True)
        assert 60.0 < flight.clock.now_s() - lost_s < 80.0
        assert not flight.mission.may_any_fly
