"""Sensors that fail in flight, batteries that are not reported, and returns that end in a hover."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.fleet.watches.condition import problems
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Hold, Land, Severity, VehicleState
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

LONG_AREA_ENU_M = ((-12.0, 10.0), (12.0, 10.0), (12.0, 170.0), (-12.0, 170.0))


def texts_of(flight: Flight, severity: Severity) -> list[str]:
    notices = [event.data for event in flight.recorder.events if isinstance(event.data, NoticeRecord)]
    return [notice.text for notice in notices if notice.severity is severity]


async def until_step(flight: Flight, number: int) -> None:
    await flight.until(lambda: len(flight.view.steps()) >= number)


async def test_a_battery_that_is_no_longer_reported_leads_home() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        await flight.commands.act(Action.PAUSE, None)
        vehicle = flight.fleet.members[2]
        vehicle.battery_fraction, vehicle.battery_silent_since_s = 0.99, flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.RETURNING)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert any("its battery has not been reported for 20 s, last at 99%" in text for text in flight.texts())


async def test_a_link_that_was_lost_is_no_battery_that_is_not_reported() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        await flight.commands.act(Action.PAUSE, None)
        vehicle = flight.fleet.members[2]
        vehicle.silent_since_s = vehicle.battery_silent_since_s = flight.clock.now_s()
        await flight.clock.sleep(25.0)
        vehicle.silent_since_s = None
        await flight.clock.sleep(5.0)
        vehicle.battery_silent_since_s = None
        await flight.commands.act(Action.RETURN, None)
        await run
    assert not any("its battery has not been reported" in text for text in flight.texts())


@pytest.mark.parametrize("problem", ["fix", "estimator"])
async def test_a_vehicle_without_a_position_is_held_and_told(problem: str) -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        vehicle = flight.fleet.members[2]
        if problem == "fix":
            vehicle.gps_fix = 1
        else:
            vehicle.estimator_problem = "its estimator has no position"
        await flight.until(lambda: flight.task(2) is Task.HELD)
        assert any(isinstance(command, Hold) for command in vehicle.commands)
        vehicle.gps_fix, vehicle.estimator_problem = 6, ""
        await flight.until(lambda: any("again" in text for text in texts_of(flight, Severity.INFO)))
        await flight.commands.act(Action.RETURN, None)
        await run
    told = {"fix": "it has lost its 3D position fix", "estimator": "its estimator has no position"}[problem]
    assert len([text for text in texts_of(flight, Severity.CRITICAL) if told in text]) == 1


@pytest.mark.parametrize("problem", ["fix", "estimator"])
async def test_a_resume_leaves_a_vehicle_without_a_position_held_until_it_has_one(problem: str) -> None:
    flight = prepare(target=None, area_enu_m=LONG_AREA_ENU_M)
    async with flying(flight) as run:
        await until_step(flight, 1)
        vehicle = flight.fleet.members[2]
        if problem == "fix":
            vehicle.gps_fix = 1
        else:
            vehicle.estimator_problem = "its estimator has no position"
        await flight.until(lambda: flight.task(2) is Task.HELD)
        await flight.commands.act(Action.HOLD, None)
        await flight.clock.sleep(2.0)
        results = {result.vehicle_id: result for result in await flight.commands.act(Action.RESUME, None)}
        told = {"fix": "it has lost its 3D position fix", "estimator": "its estimator has no position"}[problem]
        assert (results[2].accepted, flight.task(2)) == (False, Task.HELD)
        assert results[2].text == f"stays held: {told}. Return it, land it, or resume it when that is over"
        await flight.clock.sleep(2.0)
        assert isinstance(vehicle.commands[-1], Hold)
        vehicle.gps_fix, vehicle.estimator_problem = 6, ""
        await flight.clock.sleep(1.0)
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert not result.accepted, "it may be gone again"
        await flight.until(lambda: any("again" in text for text in texts_of(flight, Severity.INFO)))
        (result,) = await flight.commands.act(Action.RESUME, (2,))
        assert (result.accepted, flight.task(2)) == (True, Task.SWARM)
        await flight.commands.act(Action.RETURN, None)
        await run


async def test_a_search_is_not_resumed_with_vehicles_that_have_no_position() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        for number in (2, 3, 4):
            flight.fleet.members[number].gps_fix = 1
        await flight.until(lambda: [flight.task(number) for number in (2, 3, 4)] == [Task.HELD] * 3)
        await flight.commands.act(Action.HOLD, None)
        with pytest.raises(MissionError, match="vehicle 2: stays held: it has lost its 3D position fix"):
            await flight.commands.act(Action.RESUME, None)
        await flight.commands.act(Action.RETURN, None)
        await run


async def test_a_vehicle_whose_position_jumps_is_held_and_told_until_it_is_back() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        vehicle = flight.fleet.members[2]
        vehicle.reported_north_m = 15.0
        await flight.until(lambda: flight.task(2) is Task.HELD)
        assert isinstance(vehicle.commands[-1], Hold)
        sent = len(vehicle.commands)
        await flight.commands.act(Action.RETURN, None)
        await flight.clock.sleep(3.0)
        assert len(vehicle.commands) == sent  # the way home from a wrong place would be another one
        vehicle.reported_north_m = 0.0
        await run
    told = [text for text in texts_of(flight, Severity.CRITICAL) if text.startswith("its position jumped by 1")]
    assert len(told) == 1
    assert "position consistent with velocity again" in texts_of(flight, Severity.INFO)
    assert flight.task(2) is Task.LANDED


async def test_a_position_that_stays_where_it_jumped_to_is_accepted() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        flight.fleet.members[2].reported_north_m = 15.0
        jumped_at_s = flight.clock.now_s()
        again = "position consistent with velocity again"
        await flight.until(lambda: again in texts_of(flight, Severity.INFO))
        assert flight.clock.now_s() - jumped_at_s == pytest.approx(10.0, abs=0.5)
        flight.fleet.members[2].reported_north_m = 0.0
        await flight.clock.sleep(11.0)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert flight.task(2) is Task.LANDED


@pytest.mark.parametrize("speed_mps", [3.0, 10.0])
async def test_a_flight_at_any_speed_is_no_jump(speed_mps: float) -> None:
    flight = prepare(target=None)
    for vehicle in flight.fleet.members.values():
        vehicle.speed_mps = speed_mps
    async with flying(flight) as run:
        await until_step(flight, 2)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert not any("its position jumped" in text for text in flight.texts())


async def test_vibration_is_told_once_and_a_short_one_not_at_all() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        flight.fleet.members[1].vibration_mps2 = 45.0
        await flight.clock.sleep(1.0)
        flight.fleet.members[1].vibration_mps2 = 5.0
        flight.fleet.members[2].vibration_mps2 = 45.0
        await flight.clock.sleep(6.0)
        await flight.commands.act(Action.RETURN, None)
        await run
    told = [text for text in texts_of(flight, Severity.WARNING) if "vibration of 45 m/s²" in text]
    assert len(told) == 1
    assert flight.task(2) is Task.LANDED


async def test_a_clock_that_drifts_for_seconds_only_is_not_reported() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        await until_step(flight, 1)
        await flight.commands.act(Action.PAUSE, None)
        flight.fleet.members[1].clock_drift = flight.fleet.members[2].clock_drift = 0.002
        await flight.clock.sleep(10.0)
        flight.fleet.members[1].clock_drift = 0.0
        await flight.clock.sleep(15.0)
        await flight.commands.act(Action.RETURN, None)
        await run
    notices = [event.data for event in flight.recorder.events if isinstance(event.data, NoticeRecord)]
    assert [notice.vehicle_id for notice in notices if "its clock drifts by +2.0 ms" in notice.text] == [2]


def test_px4_has_its_own_measure_of_vibration() -> None:
    def told(autopilot: str) -> bool:
        return bool(problems(VehicleState(vehicle_id=1, autopilot=autopilot, vibration_mps2=12.0)))

    assert [told("px4"), told("arducopter")] == [True, False]


async def returning_by_itself(flight: Flight) -> FakeVehicle:
    """Return the mission while a vehicle flies home by its own decision, to a hover above its launch point."""
    await until_step(flight, 2)
    vehicle = flight.fleet.members[2]
    vehicle.mode = FlightMode.RETURN
    vehicle.fly_to(vehicle.home_enu_m + np.array([0.0, 0.0, 30.0]))
    await flight.commands.act(Action.RETURN, None)
    return vehicle


async def test_a_return_of_its_own_that_ends_in_a_hover_is_landed() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await returning_by_itself(flight)
        await flight.until(lambda: flight.mission.phase is Phase.LAND and not vehicle.is_moving())
        hovers_at_s = flight.clock.now_s()
        await flight.until(lambda: isinstance(vehicle.commands[-1], Land))
        assert flight.clock.now_s() - hovers_at_s < 20.0
        await run
    assert flight.task(2) is Task.LANDED


async def test_a_vehicle_that_hovers_in_hold_after_its_return_is_landed_at_once() -> None:
    flight = prepare()
    async with flying(flight) as run:
        vehicle = await returning_by_itself(flight)
        await flight.until(lambda: flight.mission.phase is Phase.LAND)
        await flight.clock.sleep(3.0)
        commands, vehicle.mode = len(vehicle.commands), FlightMode.HOLD
        changed_at_s = flight.clock.now_s()
        await flight.until(lambda: len(vehicle.commands) > commands)
        assert flight.clock.now_s() - changed_at_s < 5.0
        await run
    assert flight.task(2) is Task.LANDED
