"""Continuous searches: the line flies along its legs without stops, and what happens to it there. In virtual time."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.in_flight.frames import FIRST_STEPS
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.ports import Capture, Goto
from aos_gcs.runtime.simulated.virtual_time import run as run_virtually
from tests.fakes.command_line import exit_status
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, flying, lose, prepare, take_over
from tests.fakes.recorded_search import write_search

virtual = pytest.mark.virtual

CAMERA_S = 0.6
"""Time from an exposure until its image is there."""
LONG_AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 90.0), (-12.0, 90.0))
GOES_ON = DetectionSettings(threshold_m2=0.3, found_min_count=2, look_steps=8)


def sweep_flight(target: tuple[float, float] | None = None, n: int = 4, **changes: object) -> Flight:
    changes = {"area_enu_m": LONG_AREA, "camera_delay_s": CAMERA_S, "errors": EXACT} | changes
    return prepare(n, target, search=SearchSettings(SearchMode.CONTINUOUS), **changes)


def swept(flight: Flight) -> list[StepRecord]:
    return [step for step in flight.view.steps() if step.branch == "sweep"]


def is_in_the_middle(flight: Flight) -> bool:
    return len(swept(flight)) >= 5


def exposures_north_m(flight: Flight, vehicle_id: int = 2) -> list[float]:
    """Return where the recorded frames of a vehicle were exposed."""
    frame = flight.mission._context.roster.local_frame()
    return [float(frame.to_enu(one.position)[1]) for _, one in flight.recorder.frames if one.vehicle_id == vehicle_id]


@virtual
async def test_the_line_flies_on_while_frames_are_taken_and_no_ground_is_left_out() -> None:
    flight = sweep_flight()
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        watch = group.create_task(flight.watch_separation())
        assert await run is Outcome.NOT_FOUND
        watch.cancel()
    assert "Scan complete: the whole area was scanned, nothing was found" in flight.texts()
    assert flight.view.snapshot().covered_fraction == 1.0
    assert flight.smallest_m >= UNLIMITED.separation_m
    # All steps but the first and the last of a leg are of frames taken in flight.
    assert len(swept(flight)) >= len(flight.view.steps()) - 2
    assert np.diff(exposures_north_m(flight)).max() <= 4.0
    gotos = [command for command in flight.fleet.members[2].commands if isinstance(command, Goto)]
    assert {goto.speed_mps for goto in gotos} == {5.0, 10.0}
    assert len(gotos) < 8


@virtual
@pytest.mark.parametrize("mode", SearchMode)
async def test_on_its_legs_the_line_is_as_wide_and_the_legs_as_close_as_planned(mode: SearchMode) -> None:
    search = SearchSettings(mode, line_spacing_m=9.0, leg_spacing_m=22.0)
    area = ((-20.0, 10.0), (20.0, 10.0), (20.0, 30.0), (-20.0, 30.0))
    flight = prepare(2, None, area_enu_m=area, camera_delay_s=CAMERA_S, errors=EXACT, search=search)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    assert [leg.start_enu_m[0] for leg in flight.mission.sortie.search.decider.progress.legs] == pytest.approx(
        [-10.0, 10.0]
    )
    frame = flight.mission._context.roster.local_frame()
    east_m: dict[int, list[float]] = {1: [], 2: []}
    for _, one in flight.recorder.frames:
        east_m[one.vehicle_id].append(float(frame.to_enu(one.position)[0]))
    assert np.abs(np.subtract(east_m[1], east_m[2])) == pytest.approx(9.0, abs=0.2)


@virtual
async def test_the_second_pass_flies_the_legs_back_beside_the_first() -> None:
    search = SearchSettings(SearchMode.CONTINUOUS, leg_spacing_m=22.0, passes=2)
    area = ((-20.0, 10.0), (20.0, 10.0), (20.0, 30.0), (-20.0, 30.0))
    flight = prepare(2, None, area_enu_m=area, camera_delay_s=CAMERA_S, errors=EXACT, search=search)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    legs = flight.mission.sortie.search.decider.progress.legs
    assert [leg.start_enu_m[0] for leg in legs] == pytest.approx([-10.0, 10.0, 12.0, -12.0], abs=2.1)
    assert legs[2].direction_enu == pytest.approx((-legs[1].direction_enu[0], -legs[1].direction_enu[1]))
    assert "Scan complete: the whole area was scanned, nothing was found" in flight.texts()
    assert flight.smallest_m >= UNLIMITED.separation_m


@virtual
async def test_what_is_in_view_stops_the_line_and_the_leg_goes_on_where_it_was_left() -> None:
    flight = sweep_flight((3.0, 50.0), detection=GOES_ON)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    phases = [step.phase for step in flight.view.steps()]
    first, last = phases.index(Phase.CONVERGE), len(phases) - phases[::-1].index(Phase.FOUND)
    north_m = exposures_north_m(flight)
    steps = [step.step for step in flight.view.steps()]
    before_m = max(north_m[: steps[first] - 1])
    # Behind the close look the line begins where the last frames without it were taken, not where it had flown to.
    assert north_m[steps[last] - 1] == pytest.approx(before_m, abs=3.5)
    assert all(step.branch == "sweep" for step in flight.view.steps()[last:-1])
    assert "Scan complete: the whole area was scanned, 1 possible person was found" in flight.texts()


@virtual
async def test_a_hold_stops_the_line_and_after_it_the_leg_goes_on() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        await flight.commands.act(Action.HOLD, None)
        held_m = {key: vehicle.position_enu_m() for key, vehicle in flight.fleet.members.items()}
        steps = len(flight.view.steps())
        await flight.clock.sleep(10.0)
        assert len(flight.view.steps()) == steps
        for key, vehicle in flight.fleet.members.items():
            assert vehicle.position_enu_m() == pytest.approx(held_m[key], abs=0.01)
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.NOT_FOUND
    assert np.diff(exposures_north_m(flight)).max() <= 6.0
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_a_pause_lets_nobody_fly_on_unseen() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(4.0)
        paused_m = flight.fleet.members[1].position_enu_m()
        await flight.clock.sleep(20.0)
        assert flight.fleet.members[1].position_enu_m() == pytest.approx(paused_m, abs=0.01)
        assert paused_m[1] < LONG_AREA[2][1] - 20.0
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.NOT_FOUND
    assert np.diff(exposures_north_m(flight)).max() <= 10.0


@virtual
async def test_a_return_in_the_middle_of_a_leg_brings_all_home() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        await flight.commands.act(Action.RETURN, None)
        await run
    assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.LANDED] * 4


@virtual
@pytest.mark.parametrize("strike", [take_over, lose])
async def test_the_others_fly_on_without_one_that_a_pilot_takes_or_that_is_lost(strike: object) -> None:
    flight = sweep_flight()
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        watch = group.create_task(flight.watch_separation())
        await flight.until(lambda: is_in_the_middle(flight))
        strike(flight.fleet.members[3])  # type: ignore[operator]
        commands = len(flight.fleet.members[3].commands)
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        sent = flight.fleet.members[3].commands[commands:]
        assert not any(isinstance(command, Goto) for command in sent)
        flight.fleet.members[3].silent_since_s = None
        flight.fleet.members[3].reclaim()
        await flight.commands.act(Action.LAND, (3,))
        assert await run is Outcome.NOT_FOUND
        watch.cancel()
    assert any("the whole area was scanned" in text for text in flight.texts())
    assert flight.smallest_m >= UNLIMITED.separation_m


@virtual
async def test_a_camera_that_fails_is_named_once_and_counted_and_the_line_flies_on() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        flight.fleet.members[3].camera_works = False
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        camera = flight.view.snapshot().vehicles[2].camera
        await run
    named = [text for text in flight.texts() if "flies on without its frames" in text]
    assert named == ["the line flies on without its frames: no image for 4 s"]
    assert camera is not None
    assert camera.failures > 3


@virtual
async def test_where_no_frame_comes_in_flight_the_search_goes_on_with_stops() -> None:
    flight = sweep_flight(area_enu_m=((-12.0, 10.0), (12.0, 10.0), (12.0, 30.0), (-12.0, 30.0)))
    for vehicle in flight.fleet.members.values():
        blind_in_flight(vehicle)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    changes = [text for text in flight.texts() if text.endswith("stops")]
    stops = "No frame has come in flight for 3 s (no image yet): the search goes on with stops"
    # Frames at rest come: it tries again, and again with stops.
    assert changes == [
        *[stops, "Frames received again. The search continues without stops"] * (len(changes) // 2),
        stops,
    ]
    assert 3 <= len(changes) <= 5, "attempts become rarer"
    assert flight.view.snapshot().covered_fraction == 1.0
    assert any(text.startswith("No frames from ") for text in flight.texts())


@virtual
async def test_a_search_without_frames_in_flight_stops_for_a_while_and_sweeps_again_once_they_come() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        for vehicle in flight.fleet.members.values():
            vehicle.camera_works = False
        await flight.until(lambda: any(text.endswith("goes on with stops") for text in flight.texts()))
        for vehicle in flight.fleet.members.values():
            vehicle.camera_works = True
        assert await run is Outcome.NOT_FOUND
    assert flight.texts().count("Frames received again. The search continues without stops") == 1
    branches = [step.branch for step in flight.view.steps()]
    at_rest = [step.step for step in flight.view.steps() if not flight.recorder.decisions[step.step].may_sweep]
    assert len(at_rest) == FIRST_STEPS - 1
    assert branches[at_rest[-1] :].count("sweep") > 5
    assert flight.view.snapshot().covered_fraction == 1.0
    assert np.diff(sorted(exposures_north_m(flight))).max() <= 10.0


def blind_in_flight(vehicle: FakeVehicle) -> None:
    """Have its images in flight not come."""
    capture = vehicle.capture

    async def capture_at_rest(deadline_s: float) -> Capture:
        vehicle.camera_works = not vehicle.is_moving()
        return await capture(deadline_s)

    object.__setattr__(vehicle, "capture", capture_at_rest)


@virtual
async def test_frames_whose_time_is_not_known_well_enough_are_left_out_and_named() -> None:
    short = ((-12.0, 10.0), (12.0, 10.0), (12.0, 40.0), (-12.0, 40.0))
    flight = sweep_flight(area_enu_m=short, uncertainty=Uncertainty(clock_s=0.2))
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    (named,) = (text for text in flight.texts() if text.endswith("the search goes on with stops"))
    assert "its time of exposure is known to ± 0.20 s, at 5.0 m/s ± 1.0 m; 0.5 m are allowed" in named
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_before_a_zone_the_line_stops_for_each_frame_and_behind_it_sweeps_again() -> None:
    zone = ((-30.0, 40.0), (30.0, 40.0), (30.0, 46.0), (-30.0, 46.0))
    flight = sweep_flight(safety=SafetyOverrides(no_go_enu_m=(zone,), margin_m=1.0))
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    branches = [step.branch for step in flight.view.steps()]
    at_zone = next(number for number, branch in enumerate(branches) if branch == "line")
    assert at_zone > 3
    assert "sweep" in branches[at_zone:]
    assert sum("is blocked" in text for text in flight.texts()) == 1


@virtual
async def test_a_single_vehicle_makes_its_aperture_by_moving() -> None:
    flight = sweep_flight((3.0, 50.0), n=1, detection=GOES_ON)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    (text,) = (text for text in flight.texts() if text.startswith("Possible person"))
    assert "seen in 3 of 3 frames" in text
    person = next(finding for finding in flight.view.snapshot().findings if finding.is_claimed)
    assert person.position_enu_m[:2] == pytest.approx((3.0, 50.0), abs=1.0)
    looks = [step for step in flight.view.steps() if step.branch == "lone look"]
    places = {step.waypoints[0].sent_enu_m for step in looks if step.waypoints}
    assert len(places) == len(looks) >= 4
    assert flight.view.snapshot().covered_fraction == 1.0


def test_a_continuous_search_is_computed_again_and_identical(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async def fly() -> None:
        flight = sweep_flight((3.0, 45.0), area_enu_m=((-12.0, 10.0), (12.0, 10.0), (12.0, 60.0), (-12.0, 60.0)))
        async with flying(flight) as outcome:
            assert await outcome is Outcome.FOUND
        assert len(swept(flight)) > 5
        write_search(tmp_path / "mission", flight.recorder)

    run_virtually(fly())
    status = exit_status(["--log-level", "error", "replay", str(tmp_path / "mission"), "--verify"])
    assert capsys.readouterr().out.startswith("identical: ")
    assert status == 0
