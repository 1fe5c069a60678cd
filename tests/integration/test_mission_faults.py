"""What goes wrong, and what an operator does at the worst moment, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.flight import FlightControl
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model import Action, ActionRecord, Outcome, Phase, Task, Verdict
from aos_gcs.mission.roster import Roster
from aos_gcs.mission.safety import SafetyLimits
from aos_gcs.mission.settings import Deadlines, FlightSettings
from aos_gcs.ports import (
    Arm,
    Capture,
    Command,
    Disarm,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    ReturnToLaunch,
    Takeoff,
)
from tests.fakes.fleet import ORIGIN, FakeFleet, FakeVehicle
from tests.fakes.mission_flight import Flight, MemoryRecorder, flying, prepare

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


# --- ways home ------------------------------------------------------------------------------------------------------


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
async def test_others_keep_off_the_ways_that_a_vehicle_may_take_by_itself(
    task: Task, mode: FlightMode, command: Command | None, passes_below: bool, crosses_its_way: bool
) -> None:
    clock, deadlines = LoopClock(), Deadlines()
    fleet = FakeFleet(clock, 2, None)
    roster = Roster(fleet, clock)
    roster.refresh()
    roster.frame = LocalFrame(ORIGIN)
    control = FlightControl(roster, clock, Journal(clock), FlightSettings(), deadlines)
    control.limits = SafetyLimits(
        fence_enu_m=np.array([[-99.0, -99.0], [99.0, -99.0], [99.0, 99.0], [-99.0, 99.0]]), floor_m=20.0, ceiling_m=60.0
    )
    mover, other = roster.members()
    for member, position_enu_m in ((mover, [0.0, 40.0, 35.0]), (other, [0.0, 20.0, 39.0])):
        vehicle = fleet.members[member.vehicle_id]
        vehicle.start_enu_m = vehicle.goal_enu_m = np.array(position_enu_m)
        vehicle.armed = True
    mover.task, other.task, fleet.members[2].mode = Task.SWARM, task, mode
    other.last_command = command
    other.home_enu_m = np.array([30.0, 20.0, 0.0])

    def is_free(target_enu_m: list[float]) -> bool:
        (record,) = control.vet({1: np.array(target_enu_m)})
        return record.verdict is Verdict.SENT

    assert is_free([0.0, 5.0, 35.0]) is passes_below
    assert is_free([60.0, 0.0, 35.0]) is crosses_its_way


async def test_who_is_coming_down_already_is_not_led_up_again() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.mission.steps()) == 2)
        await flight.mission.act(Action.RETURN, (1,))
        await flight.mission.act(Action.LAND, (2,))
        await flight.clock.sleep(0.5)
        await flight.mission.act(Action.RETURN, None)
        await run
    assert flight.fleet.members[1].commands[-1] == ReturnToLaunch()
    assert flight.fleet.members[2].commands[-1] == Land()
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


async def test_a_pilot_is_never_overruled_on_the_way_down() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.mission.steps()) == 2)
        vehicle = flight.fleet.members[3]
        vehicle.fly_to(vehicle.position_enu_m())
        vehicle.mode, commands = FlightMode.MANUAL, len(vehicle.commands)
        await flight.mission.act(Action.RETURN, None)
        await run
    assert vehicle.commands[commands:] == []
    assert any("flown by its pilot" in text for text in flight.texts())


async def test_who_is_heard_again_during_the_return_is_sent_home_and_not_landed_where_it_is() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.mission.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        await flight.mission.act(Action.RETURN, None)
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.position_enu_m()
        vehicle.silent_since_s = None
        await run
    assert vehicle.commands[-1] == ReturnToLaunch()
    assert not any(isinstance(command, Land) for command in vehicle.commands)


async def test_a_lost_vehicle_whose_failsafe_brings_it_home_is_left_alone() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.mission.steps()) == 2)
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        vehicle.mode = FlightMode.RETURN
        vehicle.silent_since_s = None
        vehicle.start_enu_m, vehicle.started_s = vehicle.position_enu_m(), flight.clock.now_s()
        vehicle.goal_enu_m, commands = vehicle.home_enu_m, len(vehicle.commands)
        await flight.mission.act(Action.RETURN, None)
        await run
    assert vehicle.commands[commands:] == []
    assert flight.task(2) is Task.LANDED
