"""Vehicles that leave the swarm, and their way down, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import UnionType

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import (
    Capture,
    Command,
    FlightMode,
    Goto,
    Hold,
    Land,
    ReturnToLaunch,
)
from tests.fakes.fleet import ORIGIN, FakeFleet, FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.roster import give_task

pytestmark = pytest.mark.virtual


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
    await flight.until(lambda: len(flight.view.steps()) == 1)
    await flight.until(lambda: flight.view.snapshot().message == "Step 2: capturing images.")
    await flight.clock.sleep(1.0)


# --- vehicles that leave in the middle of a step ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "command"), [(Action.HOLD, Hold), (Action.RETURN, Goto | Land), (Action.LAND, Land)]
)
async def test_a_step_does_not_command_a_vehicle_that_has_left(action: Action, command: type | UnionType) -> None:
    flight = prepare()
    slow_cameras(flight)
    async with flying(flight) as run:
        await in_a_capture(flight)
        await flight.commands.act(action, (1,))
        await flight.until(lambda: len(flight.view.steps()) == 3)
        assert isinstance(flight.fleet.members[1].commands[-1], command)
        record = {record.vehicle_id: record for record in flight.view.steps()[1].waypoints}[1]
        assert record.sent_enu_m is None
        assert "left the swarm" in record.reason
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_step_does_not_take_a_vehicle_from_its_pilot() -> None:
    flight = prepare()
    slow_cameras(flight)
    async with flying(flight) as run:
        await in_a_capture(flight)
        vehicle = flight.fleet.members[2]
        vehicle.mode, commands = FlightMode.MANUAL, len(vehicle.commands)
        await flight.until(lambda: len(flight.view.steps()) == 4)
        assert vehicle.commands[commands:] == []
        vehicle.mode = FlightMode.HOLD
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert result.accepted
        await flight.until(lambda: len(flight.view.steps()) == 6)
        assert 2 in flight.view.steps()[-1].fitness
        await flight.commands.act(Action.ABORT, None)
        await run


# --- return ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("task", "mode", "command", "passes_below", "crosses_its_way"),
    [
        (Task.RETURNING, FlightMode.GUIDED, None, True, True),
        (Task.HELD, FlightMode.HOLD, Hold(), True, True),
        (Task.HELD, FlightMode.MANUAL, Hold(), False, True),
        (Task.RETURNING, FlightMode.RETURN, None, False, False),
        (Task.RETURNING, FlightMode.GUIDED, ReturnToLaunch(), False, False),
        (Task.LOST, FlightMode.GUIDED, None, False, False),
        (Task.LANDING, FlightMode.LAND, None, False, True),
        (Task.LANDING, FlightMode.GUIDED, Land(), False, True),
    ],
)
async def test_others_keep_clear_of_the_paths_of_a_failsafe(
    task: Task, mode: FlightMode, command: Command | None, passes_below: bool, crosses_its_way: bool
) -> None:
    clock, deadlines = LoopClock(), Deadlines()
    fleet = FakeFleet(clock, 2, None)
    roster = Roster(fleet, clock)
    roster.refresh()
    roster.frame = LocalFrame(ORIGIN)
    settings = FlightSettings()
    limits = SafetyLimits(
        fence_enu_m=np.array([[-99.0, -99.0], [99.0, -99.0], [99.0, 99.0], [-99.0, 99.0]]), floor_m=20.0, ceiling_m=60.0
    )
    bounds = FlightBounds(settings.arrival_radius_m, limits)
    control = FlightControl(roster, clock, Journal(clock), settings, deadlines, bounds=bounds)
    mover, other = roster.members()
    for member, position_enu_m in ((mover, [0.0, 40.0, 35.0]), (other, [0.0, 20.0, 39.0])):
        vehicle = fleet.members[member.vehicle_id]
        vehicle.start_enu_m = vehicle.goal_enu_m = np.array(position_enu_m)
        vehicle.armed = True
    give_task(roster, mover, Task.SWARM)
    give_task(roster, other, task)
    fleet.members[2].mode = mode
    other.last_command = command
    other.home_enu_m = np.array([30.0, 20.0, 0.0])

    def is_free(target_enu_m: list[float]) -> bool:
        (record,) = control.vet({1: np.array(target_enu_m)})
        return record.verdict is WaypointVerdict.SENT

    assert is_free([0.0, 5.0, 35.0]) is passes_below
    assert is_free([60.0, 0.0, 35.0]) is crosses_its_way


async def test_a_vehicle_that_descends_already_is_not_sent_up_again() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.fleet.members[1].execute(ReturnToLaunch(), 0.0)  # as its failsafe would
        await flight.commands.act(Action.LAND, (2,))
        await flight.clock.sleep(0.5)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert flight.fleet.members[1].commands[-1] == ReturnToLaunch()
    assert flight.fleet.members[2].commands[-1] == Land()
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


@pytest.mark.parametrize("others_fly", [True, False])
async def test_a_vehicle_that_was_just_ordered_to_land_is_not_sent_home(others_fly: bool) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        if not others_fly:
            for number in (1, 3, 4):
                await flight.fleet.members[number].execute(ReturnToLaunch(), 0.0)  # as their failsafes would
        # Its heartbeats tell its former mode while the order is on its way.
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = flight.clock.now_s()
        landing = asyncio.create_task(flight.commands.act(Action.LAND, (2,)))
        await flight.clock.sleep(0.05)
        await flight.commands.act(Action.RETURN, None)
        await flight.clock.sleep(0.5)
        vehicle.silent_since_s = None
        await landing
        await run
    assert not any(isinstance(command, Goto) for command in vehicle.commands[vehicle.commands.index(Land()) :])
    assert vehicle.commands[-1] == Land()
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


async def test_a_pilot_is_never_overruled_on_the_way_down() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        vehicle.fly_to(vehicle.position_enu_m())
        vehicle.mode, commands = FlightMode.MANUAL, len(vehicle.commands)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert vehicle.commands[commands:] == []
    assert any("flown by its pilot" in text for text in flight.texts())


async def test_a_vehicle_heard_again_during_the_return_flies_home_and_does_not_land_where_it_is() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        await flight.commands.act(Action.RETURN, None)
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.position_enu_m()
        vehicle.silent_since_s = None
        await run
    assert vehicle.commands[-1] == ReturnToLaunch()
    assert not any(isinstance(command, Land) for command in vehicle.commands)


@pytest.mark.parametrize("action", [Action.HOLD, Action.PAUSE, Action.RETURN, Action.LAND])
async def test_actions_on_all_name_the_vehicles_not_reached(action: Action) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        results = {result.vehicle_id: result for result in await flight.commands.act(action, None)}
        assert [results[number].accepted for number in (1, 2, 3, 4)] == [True, False, True, True]
        assert "cannot be reached" in results[2].text
        if action in {Action.HOLD, Action.PAUSE}:
            await flight.commands.act(Action.RETURN, None)
        flight.fleet.members[2].silent_since_s = None
        await run


async def test_a_lost_vehicle_whose_failsafe_brings_it_home_is_left_alone() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        vehicle.mode = FlightMode.RETURN
        vehicle.silent_since_s = None
        vehicle.start_enu_m, vehicle.started_s = vehicle.position_enu_m(), flight.clock.now_s()
        vehicle.goal_enu_m, commands = vehicle.home_enu_m, len(vehicle.commands)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert vehicle.commands[commands:] == []
    assert flight.task(2) is Task.LANDED


# --- batteries and motors --------------------------------------------------------------------------------------------


async def test_a_vehicle_with_a_low_battery_that_refuses_to_return_is_commanded_again() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle: FakeVehicle = flight.fleet.members[3]
        await flight.commands.act(Action.PAUSE, None)  # or the mission would be over before the vehicle gives in
        told = len(vehicle.commands)
        vehicle.refuses, vehicle.battery_fraction = frozenset({Goto}), 0.1
        await flight.clock.sleep(12.0)
        assert 4 <= len(vehicle.commands) - told <= 14
        vehicle.refuses = frozenset()
        await flight.until(lambda: flight.task(3) is Task.LANDED)
        assert vehicle.position_enu_m() == pytest.approx(vehicle.home_enu_m, abs=0.6)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_that_cannot_be_flown_home_in_time_is_handed_to_its_autopilot() -> None:
    flight = prepare(deadlines=Deadlines(connect_s=5.0, preflight_s=5.0, capture_s=5.0, transfer_s=15.0))
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle: FakeVehicle = flight.fleet.members[3]
        vehicle.refuses, vehicle.battery_fraction = frozenset({Goto}), 0.1
        await flight.commands.act(Action.PAUSE, None)
        await flight.until(lambda: vehicle.mode is FlightMode.RETURN)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert flight.task(3) is Task.LANDED


async def test_a_battery_that_empties_fast_brings_its_vehicle_home_in_time() -> None:
    """The way home takes about 9 % at 0.2 % per second and some 40 m away: below 29 % the vehicle leaves."""
    flight = prepare()
    vehicle: FakeVehicle = flight.fleet.members[2]
    vehicle.battery_fraction = 0.5
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.PAUSE, None)
        started_s = flight.clock.now_s()
        while flight.task(2) is Task.SWARM:
            vehicle.battery_fraction = 0.5 - 0.002 * (flight.clock.now_s() - started_s)
            await flight.clock.sleep(0.5)
        assert 0.25 < vehicle.battery_fraction < 0.32
        assert any("must be left" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run
