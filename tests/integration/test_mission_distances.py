"""Vehicles that come too close, fall silent or stop in flight, on a fake fleet in virtual time."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Goto, Hold, ReturnToLaunch
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

LONG_AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 600.0), (-12.0, 600.0))


async def hovering(flight: Flight) -> FlightControl:
    """Pause the mission after two steps, and return its control once all vehicles hover."""
    await flight.until(lambda: len(flight.view.steps()) == 2)
    await flight.commands.act(Action.PAUSE, None)
    await flight.until(lambda: not any(vehicle.is_moving() for vehicle in flight.fleet.members.values()))
    return flight.mission.sortie.context.flight


async def test_of_two_that_come_too_close_the_later_mover_is_held() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await hovering(flight)
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
        run.cancel()


async def test_an_old_position_is_reported_and_not_trusted() -> None:
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
    """The last word of the vehicles is a speed: none hovers, which must not count as cameras that deliver nothing."""
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


@pytest.mark.parametrize(
    ("silent_s", "meanwhile", "task", "words"),
    [
        (12.0, {}, Task.SWARM, "link restored after 12 s: it goes on in the swarm"),
        (40.0, {}, Task.HELD, "link restored after 40 s: it waits outside of the swarm. Resume it, or return it"),
        (
            12.0,
            {"mode": FlightMode.RETURN},
            Task.HELD,
            "link restored, but it left the swarm: its mode changed to RETURN",
        ),
        (
            12.0,
            {"mode": FlightMode.MANUAL},
            Task.HELD,
            "link restored, but it left the swarm: its mode changed to MANUAL",
        ),
        (12.0, {"failsafe": "battery"}, Task.HELD, "link restored, but it left the swarm: its failsafe is active"),
        (12.0, {"taken_over": "a pilot flies it"}, Task.HELD, "link restored, but it left the swarm: a pilot flies it"),
    ],
)
async def test_a_vehicle_heard_again_rejoins_only_where_nothing_else_can_have_flown_it(
    silent_s: float, meanwhile: dict[str, object], task: Task, words: str
) -> None:
    flight = prepare(target=None, area_enu_m=LONG_AREA, camera_delay_s=1.0)
    vehicle = flight.fleet.members[2]
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle.silent_since_s = flight.clock.now_s()
        await flight.clock.sleep(silent_s)
        assert flight.task(2) is Task.LOST
        for name, value in meanwhile.items():
            setattr(vehicle, name, value)
        commands, vehicle.silent_since_s = len(vehicle.commands), None
        await flight.until(lambda: flight.task(2) is not Task.LOST)
        await flight.clock.sleep(10.0)
        assert flight.task(2) is task
        assert any(isinstance(command, Goto) for command in vehicle.commands[commands:]) is (task is Task.SWARM)
        run.cancel()
    assert next(text for text in flight.texts() if "link restored" in text).startswith(words)


async def test_a_vehicle_heard_again_gets_nothing_before_its_mode_is_known() -> None:
    """The first packets after a loss may be positions: the mode is the one before, whatever has happened since."""
    flight = prepare(target=None, area_enu_m=LONG_AREA, camera_delay_s=1.0)
    vehicle = flight.fleet.members[2]
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        vehicle.silent_since_s = vehicle.heartbeat_silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        commands, vehicle.silent_since_s = len(vehicle.commands), None
        await flight.clock.sleep(3.0)
        assert flight.task(2) is Task.LOST
        vehicle.mode, vehicle.heartbeat_silent_since_s = FlightMode.RETURN, None
        await flight.until(lambda: flight.task(2) is Task.HELD)
        assert not vehicle.commands[commands:]
        run.cancel()


async def test_a_vehicle_held_on_its_way_is_not_crossed_by_another() -> None:
    """Held by the vetting, it flies on to its former waypoint."""
    flight = prepare()
    async with flying(flight) as run:
        control = await hovering(flight)
        crossed, crossing = flight.fleet.members[2], flight.fleet.members[1]
        start_enu_m = crossed.position_enu_m()
        await control.send(control.vet({2: start_enu_m + np.array([20.0, 0.0, 0.0])}))
        crossed.speed_mps = 1.0
        crossing.fly_to(start_enu_m + np.array([10.0, -10.0, 0.0]))
        await flight.clock.sleep(2.0)
        asked = {1: start_enu_m + np.array([10.0, 10.0, 0.0]), 2: np.full(3, np.nan)}
        granted, held = control.vet(asked)
        assert held.verdict is WaypointVerdict.HELD
        assert crossed.is_moving()
        assert granted.verdict is WaypointVerdict.SHORTENED
        assert "it would pass vehicle 2" in granted.reason
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_that_brakes_counts_where_it_will_stop() -> None:
    flight = prepare()
    async with flying(flight) as run:
        control = await hovering(flight)
        braking, other = flight.fleet.members[2], flight.fleet.members[1]
        start_enu_m = braking.position_enu_m()
        await flight.commands.act(Action.HOLD, (2,))
        braking.speed_mps = 10.0
        braking.fly_to(start_enu_m + np.array([100.0, 0.0, 0.0]))
        other.start_enu_m = other.goal_enu_m = start_enu_m + np.array([10.0, -10.0, 0.0])
        (granted,) = control.vet({1: start_enu_m + np.array([10.0, 10.0, 0.0])})
        assert "it would pass vehicle 2" in granted.reason
        braking.start_enu_m = braking.goal_enu_m = start_enu_m
        await flight.commands.act(Action.ABORT, None)
        await run
