"""Operators' actions at the worst moment, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import numpy as np
import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import (
    Arm,
    Command,
    Disarm,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    Takeoff,
)
from tests.fakes.fleet import FRAME, FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


async def told_to_climb(flight: Flight) -> None:
    """Wait for the moment in which all have been told to take off and none has left the ground."""
    async with flight.clock.timeout_at(flight.clock.now_s() + 60.0):
        while not all(Takeoff in map(type, vehicle.commands) for vehicle in flight.fleet.members.values()):
            await flight.clock.sleep(5e-4)
    assert all(vehicle.state.landed is LandedState.ON_GROUND for vehicle in flight.fleet.members.values())


@pytest.mark.parametrize("after_s", [0.0, 4.0])
async def test_hold_in_a_climb_stops_all_and_resume_continues(after_s: float) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await told_to_climb(flight)
        await flight.clock.sleep(after_s)
        results = await flight.commands.act(Action.HOLD, None)
        assert [result.accepted for result in results] == [True] * 4
        heights_m = [vehicle.position_enu_m()[2] for vehicle in flight.fleet.members.values()]
        await flight.clock.sleep(20.0)
        assert heights_m == [vehicle.position_enu_m()[2] for vehicle in flight.fleet.members.values()]
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert len(flight.view.steps()[-1].fitness) == 4


@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND, Action.ABORT])
@pytest.mark.parametrize("after_s", [0.0, 4.0])
async def test_return_land_and_abort_work_in_a_climb(action: Action, after_s: float) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await told_to_climb(flight)
        await flight.clock.sleep(after_s)
        started_s = flight.clock.now_s()
        await flight.commands.act(action, None)
        await run
    assert flight.clock.now_s() - started_s < 90.0
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4
    assert not any(isinstance(command, Disarm) for v in flight.fleet.members.values() for command in v.commands)


async def test_an_abort_while_motors_start_leaves_no_vehicle_armed() -> None:
    """An autopilot arms a while after it was told to, whether anybody still waits for it or not."""
    flight = prepare()

    def arm_late(vehicle: FakeVehicle) -> Callable:
        execute = vehicle.execute

        async def late(command: Command, deadline_s: float) -> None:
            if isinstance(command, Arm):
                asyncio.get_running_loop().call_later(1.0, setattr, vehicle, "armed", True)
                await flight.clock.sleep(1.0)
            elif isinstance(command, Disarm):
                await flight.clock.sleep(1.5)
            await execute(command, deadline_s)

        return late

    for vehicle in flight.fleet.members.values():
        vehicle.execute = arm_late(vehicle)  # type: ignore[method-assign]
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.ARM)
        await flight.clock.sleep(0.5)
        await flight.commands.act(Action.ABORT, None)
        assert await run is Outcome.ABORTED
    assert not any(vehicle.armed for vehicle in flight.fleet.members.values())
    assert not any(Takeoff in map(type, vehicle.commands) for vehicle in flight.fleet.members.values())


async def test_motors_that_stopped_while_held_on_the_ground_are_started_again() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await told_to_climb(flight)
        await flight.commands.act(Action.HOLD, None)
        for vehicle in flight.fleet.members.values():
            vehicle.armed = False
        await flight.clock.sleep(5.0)
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert all(vehicle.commands.count(Arm()) == 2 for vehicle in flight.fleet.members.values())


async def test_a_silent_vehicle_delays_the_hold_of_no_other() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.fleet.members[1].silent_since_s = flight.clock.now_s()
        held_at_s = flight.clock.now_s()
        holding = asyncio.create_task(flight.commands.act(Action.HOLD, None))
        for _ in range(5):
            await asyncio.sleep(0)
        assert all(isinstance(v.commands[-1], Hold) for v in flight.fleet.members.values())
        assert flight.clock.now_s() - held_at_s < 0.01
        await flight.commands.act(Action.ABORT, None)
        await run
        assert [result.accepted for result in await holding] == [False, True, True, True]


async def test_a_held_landing_can_be_turned_into_a_return_that_climbs_first() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.LAND, None)
        await flight.until(lambda: all(isinstance(v.commands[-1], Land) for v in flight.fleet.members.values()))
        with pytest.raises(MissionError, match="Hold them first"):
            await flight.commands.act(Action.RETURN, None)
        await flight.clock.sleep(2.0)
        await flight.commands.act(Action.HOLD, None)
        places_m = {number: v.position_enu_m() for number, v in flight.fleet.members.items()}
        await flight.commands.act(Action.RETURN, None)
        await run
    for number, vehicle in flight.fleet.members.items():
        hold = max(i for i, command in enumerate(vehicle.commands) if isinstance(command, Hold))
        first = next(command for command in vehicle.commands[hold:] if isinstance(command, Goto))
        climb_m = FRAME.to_enu(first.position) - places_m[number]
        assert np.hypot(*climb_m[:2]) < 0.01
        assert climb_m[2] > 5.0
        assert np.hypot(*(vehicle.position_enu_m() - vehicle.home_enu_m)[:2]) < 0.6


async def test_a_vehicle_that_was_descending_continues_after_a_hold_of_all() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        returning, landing = flight.fleet.members[4], flight.fleet.members[1]
        await flight.commands.act(Action.RETURN, (4,))
        await flight.commands.act(Action.LAND, (1,))
        await flight.commands.act(Action.HOLD, None)
        assert all(isinstance(vehicle.commands[-1], Hold) for vehicle in flight.fleet.members.values())
        results = await flight.commands.act(Action.RESUME, None)
        assert {result.vehicle_id: result.accepted for result in results} == {1: True, 4: True}
        await flight.until(lambda: isinstance(returning.commands[-1], Goto))
        assert landing.commands[-1] == Land()
        await run
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


async def test_actions_on_all_leave_a_pilot_alone_and_say_so() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.fly_to(vehicle.position_enu_m())
        vehicle.mode, commands = FlightMode.MANUAL, len(vehicle.commands)
        for action in (Action.HOLD, Action.RETURN):
            results = {result.vehicle_id: result for result in await flight.commands.act(action, None)}
            assert [results[number].accepted for number in (1, 2, 3, 4)] == [True, False, True, True]
            assert "pilot" in results[2].text
        assert vehicle.commands[commands:] == []
        (result,) = await flight.commands.act(Action.HOLD, (2,))
        assert result.accepted
        await run


async def test_an_abort_is_not_undone_by_a_start_right_behind_it() -> None:
    flight = prepare(auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        results = await asyncio.gather(
            flight.commands.act(Action.ABORT, None),
            flight.commands.act(Action.START, None),
            return_exceptions=True,
        )
        assert isinstance(results[1], MissionError)
        assert await run is Outcome.ABORTED
    assert not any(vehicle.commands for vehicle in flight.fleet.members.values())


async def test_two_starts_at_once_start_one_mission() -> None:
    flight = prepare(auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        await asyncio.gather(*[flight.commands.act(Action.START, None) for _ in range(2)], return_exceptions=True)
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        assert all(vehicle.commands.count(Arm()) == 1 for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize(
    "actions",
    [
        (Action.RETURN, Action.HOLD, Action.RESUME),
        (Action.RETURN, Action.ABORT),
        (Action.HOLD, Action.HOLD, Action.RESUME, Action.RETURN),
        (Action.HOLD, Action.RETURN),
        (Action.LAND, Action.HOLD, Action.RESUME),
        (Action.PAUSE, Action.HOLD, Action.LAND),
    ],
)
async def test_actions_right_after_one_another_bring_all_down(actions: tuple[Action, ...]) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.clock.sleep(0.2)
        await asyncio.gather(*[flight.commands.act(action, None) for action in actions])
        await run
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4
