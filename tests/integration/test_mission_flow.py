"""Whole missions of the coordinator on a fake fleet, in virtual time."""

from __future__ import annotations

import asyncio
import math

import numpy as np
import pytest

from aos_gcs.errors import CaptureError, MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.phases import PHASE_NAMES
from aos_gcs.planning.settings import Deadlines, FlightSettings, PreflightSettings
from aos_gcs.ports import Arm, Capture, Goto, Hold, Land, ReturnToLaunch, Severity
from tests.fakes.mission_flight import TARGET, flying, prepare

pytestmark = pytest.mark.virtual

NO_CAMERA = PreflightSettings(upload_fence=True, overrides={"camera": "it fails on purpose"})


async def test_a_whole_mission_finds_the_target_and_lands_all() -> None:
    flight = prepare()
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    snapshot = flight.view.snapshot()
    assert snapshot.phase is Phase.DONE
    assert [vehicle.task for vehicle in snapshot.vehicles] == [Task.LANDED] * 4
    assert snapshot.target is not None
    assert np.hypot(*np.subtract(snapshot.target.position_enu_m[:2], TARGET)) < 0.5
    phases = [text for text in flight.texts() if text in PHASE_NAMES.values()]
    assert phases == [PHASE_NAMES[phase] for phase in Phase if phase is not Phase.CONNECT]
    assert snapshot.min_separation_m is not None
    assert snapshot.min_separation_m >= 2.0 - 1e-6
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.outcome is Outcome.FOUND
    notices = [event.data for event in flight.recorder.events if isinstance(event.data, NoticeRecord)]
    news = [notice.text for notice in notices if notice.severity is Severity.NEWS]
    assert [text.split(" (")[0] for text in news] == ["Possible person"]


async def test_each_step_is_recorded_before_its_waypoints_are_sent() -> None:
    flight = prepare()
    gotos_at_flush: dict[int, int] = {}
    steps_told: dict[int, int] = {}

    def count() -> None:
        gotos = sum(isinstance(command, Goto) for v in flight.fleet.members.values() for command in v.commands)
        gotos_at_flush.setdefault(max(flight.recorder.steps, default=0), gotos)
        steps_told[max(flight.recorder.steps, default=0)] = len(flight.view.steps())

    flight.recorder.on_flush = count
    async with flying(flight) as run:
        await run
    first_step_gotos = gotos_at_flush[1]
    for step in range(1, 6):
        assert gotos_at_flush[step] == first_step_gotos + 4 * (step - 1)
        # No step is published before its frames are on the disk, either.
        assert steps_told[step] == step - 1
    assert {step for step, _ in flight.recorder.frames} == set(flight.recorder.steps)


@pytest.mark.parametrize("reverse_heading", [True, False])
async def test_vehicles_turn_round_from_step_to_step_while_a_target_may_be_in_view(reverse_heading: bool) -> None:
    flight = prepare(flight=FlightSettings(reverse_heading=reverse_heading))
    async with flying(flight) as run:
        await run
    headings = [{record.heading_rad for record in step.waypoints} for step in flight.view.steps() if step.waypoints]
    blind = next(number for number, one in enumerate(headings) if one != {None}) if reverse_heading else len(headings)
    assert headings[:blind] == [{None}] * blind
    assert 0 < blind < len(headings) or not reverse_heading
    assert headings[blind : blind + 3] == [{math.pi}, {0.0}, {math.pi}][: len(headings) - blind]
    told = {command.heading_rad for command in flight.fleet.members[1].commands if isinstance(command, Goto)}
    assert told == ({None, 0.0, math.pi} if reverse_heading else {None})


async def test_an_empty_area_is_scanned_to_its_end_and_everybody_returns() -> None:
    flight = prepare(target=None)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    furthest_m = max(record.requested_enu_m[1] for step in flight.view.steps() for record in step.waypoints)
    assert furthest_m >= 68.0
    assert all(not vehicle.armed for vehicle in flight.fleet.members.values())


async def test_a_silent_vehicle_is_left_out_and_the_swarm_goes_on() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        assert await run is Outcome.FOUND
    assert flight.task(2) is Task.LOST
    last = flight.view.steps()[-1]
    assert set(last.fitness) == {1, 3, 4}
    assert any("link lost" in text for text in flight.texts())


async def test_the_image_of_a_vehicle_that_is_lost_is_not_awaited() -> None:
    flight = prepare(deadlines=Deadlines(capture_s=300.0))
    silent = flight.fleet.members[2]

    async def fall_silent(deadline_s: float) -> Capture:
        silent.silent_since_s = flight.clock.now_s()
        await flight.clock.sleep(deadline_s - flight.clock.now_s())
        raise CaptureError("the camera delivers nothing")

    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        silent.capture = fall_silent  # type: ignore[method-assign]
        await flight.until(lambda: flight.task(2) is Task.LOST)
        lost_s, steps = flight.clock.now_s(), len(flight.view.steps())
        await flight.until(lambda: len(flight.view.steps()) == steps + 2)
        assert flight.clock.now_s() - lost_s < 30.0
        await flight.commands.act(Action.ABORT, None)
        await run
    assert any("its link was lost before its image came" in text for text in flight.texts())


async def test_a_vehicle_that_refuses_its_waypoint_keeps_no_other_waiting() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        flight.fleet.members[2].refuses = frozenset({Goto})
        assert await run is Outcome.FOUND
    assert any("Goto denied" in text for text in flight.texts())
    assert "has not reached its waypoint in time" not in flight.texts()


async def test_a_camera_that_delivers_nothing_is_named_and_the_step_goes_on() -> None:
    flight = prepare(preflight=NO_CAMERA)
    flight.fleet.members[3].camera_works = False
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert all("delivers nothing" in step.missing[3] for step in flight.view.steps())
    assert all(3 not in step.fitness for step in flight.view.steps())


async def test_without_any_frame_the_mission_fails_and_returns() -> None:
    flight = prepare(preflight=NO_CAMERA)
    for vehicle in flight.fleet.members.values():
        vehicle.camera_works = False
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert [vehicle.task for vehicle in flight.view.snapshot().vehicles] == [Task.LANDED] * 4


async def test_all_links_lost_ends_the_mission() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        for vehicle in flight.fleet.members.values():
            vehicle.silent_since_s = flight.clock.now_s()
        assert await run is Outcome.FAILED
    assert "All vehicles are lost" in flight.view.snapshot().message


async def test_missing_vehicles_end_the_mission_on_the_ground() -> None:
    flight = prepare(vehicles=5)
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert "4 of 5" in flight.view.snapshot().message
    assert not any(vehicle.commands for vehicle in flight.fleet.members.values())


async def test_hold_stops_everybody_at_once_and_resume_goes_on() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 3)
        results = await flight.commands.act(Action.HOLD, None)
        assert all(result.accepted for result in results)
        assert flight.mission.suspension is Suspension.HELD
        assert all(isinstance(vehicle.commands[-1], Hold) for vehicle in flight.fleet.members.values())
        steps = len(flight.view.steps())
        await flight.clock.sleep(20.0)
        assert len(flight.view.steps()) == steps
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND


async def test_pause_lets_the_step_in_hand_finish() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 3)
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(30.0)
        assert len(flight.view.steps()) <= 4
        assert not any(isinstance(c, Hold) for v in flight.fleet.members.values() for c in v.commands)
        assert not any(vehicle.is_moving() for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND


async def test_one_held_vehicle_leaves_the_swarm_and_comes_back() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.HOLD, (4,))
        await flight.until(lambda: len(flight.view.steps()) == 5)
        assert set(flight.view.steps()[-1].fitness) == {1, 2, 3}
        (result,) = await flight.commands.act(Action.RESUME, (4,))
        assert result.accepted
        assert await run is Outcome.FOUND
    assert 4 in flight.view.steps()[-1].fitness


@pytest.mark.parametrize(("action", "outcome"), [(Action.RETURN, Outcome.NOT_FOUND), (Action.ABORT, Outcome.ABORTED)])
async def test_return_and_abort_bring_everybody_to_the_launch_points(action: Action, outcome: Outcome) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(action, None)
        assert await run is outcome
    for vehicle in flight.fleet.members.values():
        assert np.hypot(*(vehicle.position_enu_m() - vehicle.home_enu_m)[:2]) < 0.6
        assert not vehicle.armed


async def test_land_all_descends_in_separate_columns() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.CONVERGE)
        await flight.commands.act(Action.LAND, None)
        await run
    places = np.array([vehicle.position_enu_m()[:2] for vehicle in flight.fleet.members.values()])
    distances = np.linalg.norm(places[:, None] - places[None], axis=2) + 99.0 * np.eye(4)
    assert distances.min() >= 1.9
    assert all(isinstance(v.commands[-1], Land) for v in flight.fleet.members.values())


async def test_a_vehicle_sent_home_alone_is_replaced_by_nobody() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        await flight.commands.act(Action.RETURN, (1,))
        assert await run is Outcome.FOUND
    assert flight.task(1) is Task.LANDED
    assert 1 not in flight.view.steps()[-1].fitness


async def test_a_low_battery_sends_a_vehicle_home() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.fleet.members[3].battery_fraction = 0.1
        assert await run is Outcome.FOUND
    vehicle = flight.fleet.members[3]
    assert ReturnToLaunch() not in vehicle.commands
    assert vehicle.commands[-1] == Land()
    assert vehicle.position_enu_m() == pytest.approx(vehicle.home_enu_m, abs=0.6)
    assert any("returns on its own: battery at 10%" in text for text in flight.texts())


async def test_two_vehicles_left_go_on_but_one_returns() -> None:
    flight = prepare(n=2)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        assert await run is Outcome.FAILED
    assert flight.task(1) is Task.LANDED


async def test_who_does_not_arm_stays_behind() -> None:
    flight = prepare()
    flight.fleet.members[1].refuses = frozenset({Arm})
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert flight.task(1) is Task.IDLE


async def test_actions_out_of_place_are_refused_and_logged() -> None:
    flight = prepare(auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        with pytest.raises(MissionError, match="no vehicle is flying"):
            await flight.commands.act(Action.LAND, None)
        with pytest.raises(MissionError, match="No vehicle is known to fly"):
            await flight.commands.act(Action.HOLD, None)
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        with pytest.raises(MissionError, match="started already"):
            await flight.commands.act(Action.START, None)
        with pytest.raises(MissionError, match="No vehicle 9"):
            await flight.commands.act(Action.HOLD, (9,))
        await flight.commands.act(Action.ABORT, None)
        await run
    assert [bool(record.refusal) for record in flight.recorder.actions] == [True, True, False, True, True, False]


async def test_cancelling_a_flying_mission_sends_everybody_home() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        run.cancel()
        await asyncio.wait({run})
    assert run.cancelled()
    assert all(isinstance(v.commands[-1], ReturnToLaunch) for v in flight.fleet.members.values())
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.outcome is Outcome.ABORTED


async def test_the_same_seed_gives_the_same_mission() -> None:
    tracks = []
    for _ in range(2):
        flight = prepare(n=3)
        async with flying(flight) as run:
            await run
        tracks.append([record.requested_enu_m for step in flight.view.steps() for record in step.waypoints])
    assert np.allclose(tracks[0], tracks[1], atol=1e-6)


async def test_a_search_that_finds_nothing_in_time_returns() -> None:
    flight = prepare(target=None, deadlines=Deadlines(connect_s=5.0, preflight_s=5.0, capture_s=5.0, search_s=8.0))
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    assert flight.view.steps()[-1].elapsed_s < 10.0
    assert any("Maximum search time reached" in text for text in flight.texts())
