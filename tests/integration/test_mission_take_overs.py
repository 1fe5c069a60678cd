"""Pilots, other stations and failsafes that fly a vehicle of the mission."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Land, LandedState, ReturnToLaunch, Severity
from tests.fakes.mission_flight import Flight, flying, prepare, take_over

pytestmark = pytest.mark.virtual


def critical_texts(flight: Flight) -> list[str]:
    notices = [event.data for event in flight.recorder.events if event.kind == "notice"]
    return [notice.text for notice in notices if notice.severity is Severity.CRITICAL]


async def test_a_pilot_who_hovers_is_left_alone_until_that_vehicle_is_resumed() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        commands = take_over(vehicle)
        steps = len(flight.view.steps())
        await flight.until(lambda: len(flight.view.steps()) >= steps + 2)
        assert flight.task(3) is Task.HELD
        refusal = flight.view.snapshot().vehicles[2].refusal
        assert refusal == "its mode changed to LOITER, not by this station"
        told = "left the swarm: its mode changed to LOITER, not by this station"
        assert any(told in text for text in critical_texts(flight))

        held = await flight.commands.act(Action.HOLD, None)
        assert [result.accepted for result in held] == [True, True, False, True]
        resumed = {result.vehicle_id: result for result in await flight.commands.act(Action.RESUME, None)}
        assert not resumed[3].accepted
        assert "Resume this vehicle alone" in resumed[3].text
        await flight.clock.sleep(5.0)
        assert vehicle.commands[commands:] == []

        (result,) = await flight.commands.act(Action.RESUME, (3,))
        assert result.accepted
        await flight.until(lambda: len(vehicle.commands) > commands)
        assert vehicle.taken_over == ""
        assert await run is Outcome.NOT_FOUND
    assert flight.task(3) is Task.LANDED


async def test_a_pilot_who_lands_is_not_stopped_by_a_hold_for_all() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        commands = take_over(vehicle, FlightMode.LAND)
        vehicle.has_pilot = True
        held = await flight.commands.act(Action.HOLD, None)
        assert [result.accepted for result in held] == [True, True, False, True]
        vehicle.has_pilot = False
        held = await flight.commands.act(Action.HOLD, None)
        assert all(result.accepted for result in held), "this landing may be the autopilot's own"
        assert len(vehicle.commands) == commands + 1
        await flight.commands.act(Action.LAND, None)
        assert await run is Outcome.NOT_FOUND


@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN, Action.LAND, Action.ABORT, Action.RESUME])
@pytest.mark.parametrize("motors_run", [True, False], ids=["motors run", "motors have just stopped"])
async def test_a_vehicle_that_its_pilot_has_landed_is_left_alone_by_actions_on_all(
    action: Action, motors_run: bool
) -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        commands = take_over(vehicle)
        await flight.until(lambda: flight.task(3) is Task.HELD)
        if action is Action.RESUME:
            await flight.commands.act(Action.HOLD, None)
        vehicle.has_pilot, vehicle.speed_mps = True, 1e3
        vehicle.fly_to(vehicle.home_enu_m)
        await flight.clock.sleep(0.2)
        if not motors_run:  # as the driver reports it, before a second heartbeat and the state on the ground confirm it
            vehicle.armed, vehicle.taken_over, vehicle.reported_landed = False, "", LandedState.LANDING
            await flight.clock.sleep(0.2)
        results = {result.vehicle_id: result for result in await flight.commands.act(action, None)}
        assert not results[3].accepted
        await flight.clock.sleep(3.0)
        vehicle.armed, vehicle.taken_over, vehicle.reported_landed = False, "", None
        await flight.until(lambda: flight.task(3) is Task.LANDED)
        if action in {Action.HOLD, Action.RESUME}:
            await flight.commands.act(Action.LAND, None)
        await run
    assert vehicle.commands[commands:] == []


async def test_a_vehicle_heard_again_stays_lost_until_its_mode_is_known() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        vehicle.silent_since_s = vehicle.heartbeat_silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(3) is Task.LOST)
        vehicle.silent_since_s = None
        commands = len(vehicle.commands)
        await flight.clock.sleep(5.0)
        assert flight.task(3) is Task.LOST
        assert vehicle.commands[commands:] == []
        vehicle.heartbeat_silent_since_s = None
        await flight.until(lambda: flight.task(3) is not Task.LOST)
        assert await run is Outcome.NOT_FOUND


async def test_a_pilot_who_hovers_is_left_alone_by_the_return_too() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        commands = take_over(flight.fleet.members[3])
        await flight.commands.act(Action.RETURN, None)
        await run
    assert flight.fleet.members[3].commands[commands:] == []
    assert any("flown by its pilot" in text for text in flight.texts())


async def test_a_take_over_on_the_way_home_is_told() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 3)
        await flight.commands.act(Action.RETURN, (3,))
        vehicle = flight.fleet.members[3]
        await flight.until(vehicle.is_moving)
        commands = take_over(vehicle)
        await flight.until(lambda: flight.task(3) is Task.HELD)
        await flight.clock.sleep(20.0)
        assert vehicle.commands[commands:] == []
        assert any("its mode changed to LOITER" in text for text in critical_texts(flight))
        run.cancel()


async def test_a_failsafe_that_hovers_gets_only_the_return() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.fly_to(vehicle.position_enu_m())
        vehicle.mode, vehicle.failsafe, commands = FlightMode.HOLD, "critical", len(vehicle.commands)
        steps = len(flight.view.steps())
        await flight.until(lambda: len(flight.view.steps()) >= steps + 2)
        assert flight.task(2) is Task.HELD
        assert any("its failsafe is active (critical" in text for text in critical_texts(flight))
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert not result.accepted
        assert vehicle.commands[commands:] == []
        await flight.commands.act(Action.RETURN, None)
        await flight.until(lambda: flight.mission.phase is Phase.DONE)
        await run
    assert {type(command) for command in vehicle.commands[commands:]} <= {ReturnToLaunch, Land}
    assert isinstance(vehicle.commands[-1], ReturnToLaunch)
    assert flight.task(2) is Task.LANDED


async def test_a_failsafe_that_hovers_with_a_low_battery_is_returned() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.mode, vehicle.failsafe, vehicle.battery_fraction = FlightMode.HOLD, "critical", 0.07
        await flight.until(lambda: isinstance(vehicle.commands[-1], ReturnToLaunch))
        await run
    assert flight.task(2) is Task.LANDED
