"""Vehicles that join a mission while it is flying, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import PreflightSettings
from aos_gcs.ports import Arm, Command, Disarm, Hold, ReturnToLaunch, Severity, Takeoff
from tests.fakes.fleet import FakeVehicle
from tests.fakes.joining import heard, paused, switch_on
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


async def climbing(flight: Flight) -> FakeVehicle:
    """Pause the mission, and have one more vehicle join; return it on its way up."""
    await paused(flight)
    vehicle = switch_on(flight, 5)
    await heard(flight, 5)
    await flight.commands.act(Action.JOIN, (5,))
    await flight.until(lambda: vehicle.position_enu_m()[2] > 20.0)
    return vehicle


async def test_a_replacement_takes_the_layer_of_the_one_that_left_and_flies_with_the_swarm() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        layers_m = {v.telemetry.vehicle_id: v.layer_height_m for v in flight.view.snapshot().vehicles}
        flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        switch_on(flight, 5)
        await heard(flight, 5)
        (result,) = await flight.commands.act(Action.JOIN, (5,))
        assert (result.accepted, result.text) == (True, "takes off and flies to the swarm")
        assert flight.task(5) is Task.JOINING
        await flight.until(lambda: flight.task(5) is Task.SWARM)
        assert flight.view.snapshot().vehicles[4].layer_height_m == layers_m[2]
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert set(flight.view.steps()[-1].fitness) == {1, 3, 4, 5}
    assert [flight.task(number) for number in (1, 2, 3, 4, 5)] == [Task.LANDED] * 5
    smallest_m = flight.view.snapshot().min_separation_m
    assert smallest_m is not None
    assert smallest_m >= 1.5


async def test_one_more_takes_the_lowest_layer_that_is_free() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        switch_on(flight, 5)
        await heard(flight, 5)
        with pytest.raises(MissionError, match="no vehicle of this mission"):
            await flight.commands.act(Action.JOIN, None)
        assert [result.vehicle_id for result in await flight.commands.act(Action.JOIN, (5,))] == [5]
        await flight.until(lambda: flight.task(5) is Task.SWARM)
        layers_m = [v.layer_height_m for v in flight.view.snapshot().vehicles]
        assert layers_m == [35.0, 37.5, 40.0, 42.5, 45.0]
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_who_joins_returns_by_itself_in_its_new_layer_also_when_it_has_flown_before() -> None:
    flight = prepare(preflight=PreflightSettings(upload_fence=True, set_return_height=True))
    async with flying(flight) as run:
        await paused(flight)
        flight.fleet.members[1].battery_fraction = flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: [flight.task(1), flight.task(2)] == [Task.LANDED] * 2)
        flight.fleet.members[2].battery_fraction = 0.9
        switch_on(flight, 5)
        await heard(flight, 5)
        assert flight.fleet.members[5].return_height_m == 30.0, "it has no layer yet"
        results = await flight.commands.act(Action.JOIN, (2, 5))
        assert [result.accepted for result in results] == [True, True]
        await flight.until(lambda: [flight.task(2), flight.task(5)] == [Task.SWARM] * 2)
        assert [flight.fleet.members[number].return_height_m for number in (2, 5)] == pytest.approx(
            [35.0, 37.5], abs=0.1
        )
        await flight.commands.act(Action.ABORT, None)
        await run
    assert flight.fleet.members[5].return_height_m == 30.0


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"return_height_m": 60.0}, "return height"),
        ({"battery_fraction": 0.3}, "battery"),
        ({"home_enu_m": np.array([200.0, 0.0, 0.0])}, "wrong side of the geofence"),
        ({"refuses": frozenset({Arm})}, None),
    ],
)
async def test_who_cannot_join_stays_on_the_ground_and_the_reason_is_told(
    change: dict[str, object], text: str | None
) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        vehicle = switch_on(flight, 5)
        for name, value in change.items():
            setattr(vehicle, name, value)
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m
        await heard(flight, 5)
        (result,) = await flight.commands.act(Action.JOIN, (5,))
        await flight.clock.sleep(1.0)
        assert result.accepted is (text is None)
        assert text is None or text in result.text
        assert flight.task(5) is Task.IDLE
        assert not vehicle.armed
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_hold_of_all_stops_a_joining_vehicle_and_resume_makes_it_part_of_the_swarm() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await climbing(flight)
        await flight.commands.act(Action.HOLD, None)
        assert isinstance(vehicle.commands[-1], Hold)
        assert not vehicle.is_moving()
        await flight.clock.sleep(10.0)
        assert isinstance(vehicle.commands[-1], Hold)
        results = await flight.commands.act(Action.RESUME, None)
        assert (5, True) in {(result.vehicle_id, result.accepted) for result in results}
        assert await run is Outcome.FOUND
    assert flight.task(5) is Task.LANDED


@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN])
async def test_who_is_still_being_checked_does_not_start_after_a_hold_or_a_return(action: Action) -> None:
    flight = prepare(preflight=PreflightSettings(upload_fence=True, set_return_height=True))
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        await paused(flight)
        vehicle = switch_on(flight, 5)
        await heard(flight, 5)
        joining = group.create_task(flight.commands.act(Action.JOIN, (5,)))
        await asyncio.sleep(0)
        await flight.commands.act(action, None)
        (result,) = await joining
        assert not result.accepted
        assert "called off" in result.text
        await flight.clock.sleep(5.0)
        assert vehicle.commands == []
        if action is Action.HOLD:
            await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN, Action.LAND])
async def test_a_list_of_vehicles_is_called_off_as_a_whole(action: Action) -> None:
    flight = prepare(preflight=PreflightSettings(upload_fence=True, set_return_height=True))
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        await paused(flight)
        vehicles = switch_on(flight, 5), switch_on(flight, 6, (26.0, -3.0, 0.0))
        await heard(flight, 6)
        joining = group.create_task(flight.commands.act(Action.JOIN, (5, 6)))
        await asyncio.sleep(0)
        await flight.commands.act(action, None)
        assert [result.text for result in await joining] == ["was called off before it started"] * 2
        await flight.clock.sleep(5.0)
        assert [vehicle.commands for vehicle in vehicles] == [[], []]
        if action is Action.HOLD:
            await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_search_that_ends_while_a_vehicle_arms_keeps_it_on_the_ground() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        vehicle = switch_on(flight, 5)
        await heard(flight, 5)
        obey = vehicle.execute

        async def end_meanwhile(command: Command, deadline_s: float) -> None:
            await obey(command, deadline_s)
            if isinstance(command, Arm):
                flight.mission.phase = Phase.RETURN

        vehicle.execute = end_meanwhile  # type: ignore[method-assign]
        await flight.commands.act(Action.JOIN, (5,))
        await flight.clock.sleep(5.0)
        assert [type(command) for command in vehicle.commands] == [Arm, Disarm]
        assert "stays on the ground: it was called off before it started" in flight.texts()
        assert flight.task(5) is Task.IDLE
        flight.mission.phase = Phase.SCAN
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_return_of_a_vehicle_that_cannot_take_off_ends_its_start_and_nothing_else() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        vehicle = switch_on(flight, 5)
        vehicle.refuses = frozenset({Takeoff})
        await heard(flight, 5)
        obey = vehicle.execute

        async def disarm_slowly(command: Command, deadline_s: float) -> None:
            if isinstance(command, Disarm):
                await flight.clock.sleep(3.0)
            await obey(command, deadline_s)

        vehicle.execute = disarm_slowly  # type: ignore[method-assign]
        await flight.commands.act(Action.JOIN, (5,))
        await flight.until(lambda: any(isinstance(command, Takeoff) for command in vehicle.commands))
        await flight.clock.sleep(1.0)
        await flight.commands.act(Action.RETURN, (5,))
        await flight.clock.sleep(6.0)
        assert [type(command) for command in vehicle.commands] == [Arm, Takeoff, ReturnToLaunch]
        assert flight.task(5) is Task.LANDED
        assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.SWARM] * 4
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize(
    ("broken", "last", "task"), [("moved_home", Disarm, Task.LANDED), ("Approach.fly", Hold, Task.HELD)]
)
async def test_a_defect_in_the_start_of_one_vehicle_holds_that_one_and_the_others_fly_on(
    monkeypatch: pytest.MonkeyPatch, broken: str, last: type, task: Task
) -> None:
    async def fail(*_: object) -> bool:
        raise RuntimeError("something unforeseen")

    flight = prepare()
    async with flying(flight) as run:
        await paused(flight)
        vehicle = switch_on(flight, 5)
        await heard(flight, 5)
        monkeypatch.setattr(f"aos_gcs.mission.fleet.reinforcements.joining.{broken}", fail)
        await flight.commands.act(Action.JOIN, (5,))
        await flight.clock.sleep(15.0)
        assert (type(vehicle.commands[-1]), flight.task(5)) == (last, task)
        found = [
            event.data for event in flight.recorder.events if event.kind == "notice" and event.data.vehicle_id == 5
        ]
        text = "internal error, it is held: RuntimeError('something unforeseen'). Return it, or land it"
        assert (Severity.CRITICAL, text) in {(notice.severity, notice.text) for notice in found}
        assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.SWARM] * 4
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_return_brings_a_joining_vehicle_home_too() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await climbing(flight)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert flight.task(5) is Task.LANDED
    assert sum(isinstance(command, Takeoff) for command in vehicle.commands) == 1
    assert vehicle.position_enu_m() == pytest.approx(vehicle.home_enu_m, abs=0.6)


async def test_without_anybody_on_the_ground_nobody_joins() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        with pytest.raises(MissionError, match="no vehicle of this mission"):
            await flight.commands.act(Action.JOIN, None)
        (result,) = await flight.commands.act(Action.JOIN, (1,))
        assert not result.accepted
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_one_whose_battery_fails_while_it_joins_comes_down_at_once() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await climbing(flight)
        vehicle.battery_fraction = 0.1
        await flight.clock.sleep(2.0)
        assert flight.task(5) is Task.LANDING
        await flight.until(lambda: flight.task(5) is Task.LANDED)
        assert np.hypot(*(vehicle.position_enu_m()[:2] - (20.0, -3.0))) < 1.0
        await flight.commands.act(Action.ABORT, None)
        await run
    assert "returns on its own: battery at 10%" in flight.texts()
