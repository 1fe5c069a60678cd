"""What goes wrong, and what an operator does at the worst moment, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
import dataclasses
from collections.abc import Callable
from types import UnionType

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
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
from tests.fakes.fleet import FRAME, ORIGIN, FakeFleet, FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.roster import give_task

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
    await flight.until(lambda: len(flight.view.steps()) == 1)
    await flight.until(lambda: flight.view.snapshot().message == "Step 2: capturing images.")
    await flight.clock.sleep(1.0)


# --- whoever leaves the swarm in the middle of a step ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "command"), [(Action.HOLD, Hold), (Action.RETURN, Goto | Land), (Action.LAND, Land)]
)
async def test_a_step_in_hand_does_not_command_who_left_meanwhile(action: Action, command: type | UnionType) -> None:
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


async def test_a_step_in_hand_does_not_wrest_a_vehicle_from_its_pilot() -> None:
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


async def test_who_is_coming_down_already_is_not_led_up_again() -> None:
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


async def test_who_is_heard_again_during_the_return_is_sent_home_and_not_landed_where_it_is() -> None:
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
async def test_actions_on_all_tell_who_was_not_reached(action: Action) -> None:
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


# --- actions at the worst moment ------------------------------------------------------------------------------------


async def told_to_climb(flight: Flight) -> None:
    """Wait for the moment in which all have been told to take off and none has left the ground."""
    async with flight.clock.timeout_at(flight.clock.now_s() + 60.0):
        while not all(Takeoff in map(type, vehicle.commands) for vehicle in flight.fleet.members.values()):
            await flight.clock.sleep(5e-4)
    assert all(vehicle.state.landed is LandedState.ON_GROUND for vehicle in flight.fleet.members.values())


@pytest.mark.parametrize("after_s", [0.0, 4.0])
async def test_hold_in_a_climb_stops_everybody_and_resume_goes_on(after_s: float) -> None:
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
async def test_every_way_down_works_in_a_climb(action: Action, after_s: float) -> None:
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


async def test_an_abort_while_motors_start_leaves_nobody_armed() -> None:
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


async def test_who_was_on_its_way_down_alone_goes_on_after_a_hold_of_all() -> None:
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
async def test_actions_right_after_one_another_bring_everybody_down(actions: tuple[Action, ...]) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.clock.sleep(0.2)
        await asyncio.gather(*[flight.commands.act(action, None) for action in actions])
        await run
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


# --- defects and disks ----------------------------------------------------------------------------------------------


async def test_a_disk_that_hangs_delays_no_hold_and_hardly_its_answer() -> None:
    flight = prepare()
    flight.recorder.is_stuck = True
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        async with asyncio.timeout(2.0):
            results = await flight.commands.act(Action.HOLD, None)
        assert all(result.accepted for result in results)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert any("action hold may be missing" in text for text in flight.texts())


async def test_a_disk_that_hangs_does_not_stop_the_search() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.recorder.is_stuck = True
        assert await run is Outcome.FOUND
    assert all(vehicle.task is Task.LANDED for vehicle in flight.view.snapshot().vehicles)
    assert any("step 4 may be missing" in text for text in flight.texts())


@pytest.mark.parametrize("culprit", ["handler", "monitor"])
async def test_a_defect_sends_everybody_home_and_is_reported(culprit: str) -> None:
    flight = prepare()
    pilot = flight.fleet.members[1]

    def fail(*_args: object) -> None:
        raise ZeroDivisionError("a defect")

    with pytest.raises(ExceptionGroup) as caught:  # noqa: PT012 - the mission is the statement
        async with flying(flight) as run:
            await flight.until(lambda: len(flight.view.steps()) == 2)
            pilot.mode = FlightMode.MANUAL
            owner, name = {
                "handler": (flight.mission.sortie.search.decider, "decide"),
                "monitor": (flight.mission._monitor._proximity, "look"),
            }[culprit]
            setattr(owner, name, fail)
            await run
    assert caught.group_contains(ZeroDivisionError)
    assert [isinstance(v.commands[-1], ReturnToLaunch) for v in flight.fleet.members.values()] == [False] + [True] * 3
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.outcome is Outcome.FAILED
    assert any("ZeroDivisionError" in text for text in flight.texts())


async def test_a_farewell_that_fails_still_closes_the_record() -> None:
    flight = prepare()

    async def fail(*_args: object) -> None:
        raise ZeroDivisionError("a broken driver")

    with pytest.raises(ExceptionGroup):  # noqa: PT012 - the mission is the statement
        async with flying(flight) as run:
            await flight.until(lambda: len(flight.view.steps()) == 2)
            flight.fleet.members[2].execute = fail  # type: ignore[method-assign]
            await run
    assert flight.recorder.outcome is not None
    assert all(isinstance(flight.fleet.members[i].commands[-1], ReturnToLaunch) for i in (1, 3, 4))


# --- batteries and motors -------------------------------------------------------------------------------------------


async def test_a_vehicle_with_a_low_battery_that_refuses_to_fly_home_is_told_again() -> None:
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


async def test_who_cannot_be_led_home_in_time_is_handed_to_its_autopilot() -> None:
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
    """At 0.2 % per second and some 40 m away, home is about 9 % away: below 29 % the vehicle leaves."""
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.PAUSE, None)
        vehicle: FakeVehicle = flight.fleet.members[2]
        started_s = flight.clock.now_s()
        while flight.task(2) is Task.SWARM:
            vehicle.battery_fraction = 0.9 - 0.002 * (flight.clock.now_s() - started_s)
            await flight.clock.sleep(0.5)
        assert 0.25 < vehicle.battery_fraction < 0.32
        assert any("must be left" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run


# --- distances in the air ------------------------------------------------------------------------------------------


async def test_of_two_that_come_too_close_the_later_mover_is_held() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.PAUSE, None)
        await flight.until(lambda: not any(vehicle.is_moving() for vehicle in flight.fleet.members.values()))
        still, drifting = flight.fleet.members[2], flight.fleet.members[3]
        flight.mission.sortie.context.roster.select([3])[0].sent_at_s = flight.clock.now_s()
        drifting.speed_mps = 2.0
        drifting.fly_to(still.position_enu_m())
        await flight.until(lambda: isinstance(drifting.commands[-1], Hold))
        await flight.clock.sleep(1.0)
        offset_m = drifting.position_enu_m() - still.position_enu_m()
        assert not isinstance(still.commands[-1], Hold)
        assert 0.0 < np.linalg.norm(offset_m) < 1.5
        assert flight.task(3) is Task.HELD
        assert any("vehicle 3 is held" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_position_that_is_old_is_told_of_and_not_trusted() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        await flight.clock.sleep(4.0)
        assert sum("its distance to others is not monitored" in text for text in flight.texts()) == 1
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_whose_motors_stop_leaves_the_swarm() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle = flight.fleet.members[3]
        vehicle.armed = False
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.position_enu_m() * [1.0, 1.0, 0.0]
        await flight.until(lambda: len(flight.view.steps()) == 4)
        assert set(flight.view.steps()[-1].fitness) == {1, 2, 4}
        await flight.commands.act(Action.ABORT, None)
        await run
    assert any("motors have stopped" in text for text in flight.texts())


async def test_vehicles_that_fall_silent_on_their_way_end_the_mission_as_lost() -> None:
    """Their last word is a speed: nobody hovers, which must not count as cameras that deliver nothing."""
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.until(lambda: all(vehicle.is_moving() for vehicle in flight.fleet.members.values()))
        for vehicle in flight.fleet.members.values():
            vehicle.silent_since_s = flight.clock.now_s()
        assert await run is Outcome.FAILED
    assert sum("All vehicles are lost" in text for text in flight.texts()) == 1
    assert not any("No camera" in text for text in flight.texts())


async def test_a_vehicle_lost_during_the_landing_is_brought_down_when_heard_again() -> None:
    flight = prepare()
    lost = flight.fleet.members[2]
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        lost.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        await flight.commands.act(Action.RETURN, None)
        await flight.until(lambda: flight.task(1) is Task.LANDED)
        lost.silent_since_s = None
        await run
    assert flight.task(2) is Task.LANDED
    assert isinstance(lost.commands[-1], ReturnToLaunch)


# --- frames that cannot be used -------------------------------------------------------------------------------------


def blind_cameras(flight: Flight, vehicle_ids: set[int]) -> None:
    """Let some cameras deliver images that show nothing."""
    for vehicle_id in vehicle_ids:
        vehicle = flight.fleet.members[vehicle_id]
        take = vehicle.capture

        async def capture(deadline_s: float, take: Callable = take) -> Capture:
            taken = await take(deadline_s)
            return dataclasses.replace(taken, image=np.full_like(taken.image, 7))

        vehicle.capture = capture  # type: ignore[method-assign]


async def test_an_image_that_shows_nothing_counts_as_missing_with_the_reason() -> None:
    flight = prepare()
    blind_cameras(flight, {1})
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        for record in flight.view.steps():
            assert list(record.missing) == [1]
            assert "the same everywhere" in record.missing[1]
            assert 1 not in record.fitness
            assert 1 in {waypoint.vehicle_id for waypoint in record.waypoints}
        assert any("goes on without its frame: its image is the same" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_swarm_whose_images_all_show_nothing_comes_home() -> None:
    flight = prepare()
    blind_cameras(flight, set(flight.fleet.members))
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert any("No camera delivered a usable frame in 3 steps" in text for text in flight.texts())
