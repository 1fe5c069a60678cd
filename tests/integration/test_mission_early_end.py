"""A mission that is ended while its vehicles are about to climb, in virtual time: none climbs further than it has."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import numpy as np
import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines
from aos_gcs.ports import Hold, Land
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

CLIMB_MPS = 1.5


def climbing_slowly(**changes: object) -> Flight:
    flight = prepare(3, auto_start=False, deadlines=Deadlines(capture_s=5.0), **changes)
    for vehicle in flight.fleet.members.values():
        vehicle.speed_mps = CLIMB_MPS
    return flight


def heights_m(flight: Flight) -> list[float]:
    return [float(vehicle.position_enu_m()[2]) for vehicle in flight.fleet.members.values()]


async def launch(flight: Flight) -> None:
    await flight.until(lambda: flight.mission.phase is Phase.READY)
    await flight.commands.act(Action.START, None)


async def highest_until_down(flight: Flight, run: asyncio.Task[object]) -> float:
    highest_m = max(heights_m(flight))
    while not run.done():
        await flight.clock.sleep(0.1)
        highest_m = max(highest_m, *heights_m(flight))
    return highest_m


@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND, Action.ABORT])
@pytest.mark.parametrize("is_held", [False, True], ids=["climbing", "held"])
async def test_vehicles_just_off_the_ground_land_at_once(action: Action, is_held: bool) -> None:
    flight = climbing_slowly()
    async with flying(flight) as run:
        await launch(flight)
        await flight.until(lambda: min(heights_m(flight)) >= 0.6)
        if is_held:
            await flight.commands.act(Action.HOLD, None)
        await flight.commands.act(action, None)
        assert await highest_until_down(flight, run) < 2.0
    for vehicle in flight.fleet.members.values():
        assert isinstance(vehicle.commands[-1], Land)
        assert not vehicle.state.armed
    assert [flight.task(number) for number in (1, 2, 3)] == [Task.LANDED] * 3


@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND])
async def test_vehicles_told_to_take_off_that_stand_yet_stay_on_the_ground(action: Action) -> None:
    flight = climbing_slowly()
    for vehicle in flight.fleet.members.values():
        vehicle.speed_mps = 0.0
    async with flying(flight) as run:
        await launch(flight)
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        await flight.clock.sleep(0.5)
        await flight.commands.act(action, None)
        assert await highest_until_down(flight, run) == pytest.approx(0.0, abs=0.1)
    assert [flight.task(number) for number in (1, 2, 3)] == [Task.LANDED] * 3


async def test_one_that_returns_alone_just_off_the_ground_lands_where_it_started() -> None:
    flight = climbing_slowly()
    async with flying(flight) as run:
        await launch(flight)
        await flight.until(lambda: min(heights_m(flight)) >= 0.6)
        await flight.commands.act(Action.RETURN, (2,))
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        assert isinstance(flight.fleet.members[2].commands[-1], Land)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_above_another_one_at_the_start_flies_home_in_its_layer() -> None:
    flight = climbing_slowly()
    async with flying(flight) as run:
        await launch(flight)
        await flight.until(lambda: min(heights_m(flight)) >= 10.0)
        await flight.commands.act(Action.HOLD, None)
        lower, upper = flight.fleet.members[1], flight.fleet.members[2]
        lower.start_enu_m = lower.goal_enu_m = upper.position_enu_m() - np.array([0.0, 0.0, 5.0])
        assert isinstance(upper.commands[-1], Hold)
        await flight.commands.act(Action.RETURN, None)
        await flight.until(lambda: bool(upper.position_enu_m()[2] > 30.0))
        await run


async def test_a_service_that_is_stopped_at_the_start_lands_its_vehicles() -> None:
    flight = climbing_slowly()
    async with flying(flight) as run:
        await launch(flight)
        await flight.until(lambda: min(heights_m(flight)) >= 0.6)
        run.cancel()
        with suppress(asyncio.CancelledError):
            await run
    assert all(isinstance(vehicle.commands[-1], Land) for vehicle in flight.fleet.members.values())
