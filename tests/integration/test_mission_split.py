"""Split swarms: some vehicles look closely while the others scan on along the leg. In virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.decisions import Group
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.in_flight.splitting import NEAR_M
from aos_gcs.planning.search_settings import LookOrder, SearchSettings
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Goto
from aos_gcs.runtime.recorded.verification import Verification, verify_mission
from aos_gcs.runtime.simulated.virtual_time import run as run_virtually
from aos_gcs.store.reader import MissionReader
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, lose, take_over
from tests.fakes.recorded_search import write_search
from tests.fakes.split_flight import (
    AREA,
    LONG_LOOK,
    is_catching_up,
    is_scanned_on,
    norths_m,
    reached_m,
    split_flight,
    steps_of,
    vehicles_of,
    waits,
)

virtual = pytest.mark.virtual


def test_the_nearest_look_closely_the_others_scan_on_and_both_are_computed_again(tmp_path: Path) -> None:
    async def fly() -> Flight:
        flight = split_flight()
        async with flying(flight) as run, asyncio.TaskGroup() as group:
            watch = group.create_task(flight.watch_separation())
            await flight.until(lambda: is_scanned_on(flight))
            began_m = reached_m(flight)
            await flight.until(lambda: flight.mission.phase is Phase.LINE)
            assert reached_m(flight) > began_m + 10.0
            assert await run is Outcome.FOUND
            watch.cancel()
        write_search(tmp_path / "mission", flight.recorder)
        return flight

    flight = run_virtually(fly())
    looking, scanning = vehicles_of(flight, Group.LOOK), vehicles_of(flight, Group.SCAN)
    assert (len(looking), len(scanning)) == (5, 3)
    assert not looking & scanning
    assert {step.phase for step in steps_of(flight, Group.LOOK)} == {Phase.CONVERGE, Phase.FOUND}
    assert {(step.phase, step.branch) for step in steps_of(flight, Group.SCAN)} == {(Phase.SCAN, "sweep")}
    assert flight.smallest_m >= UNLIMITED.separation_m
    assert flight.view.snapshot().covered_fraction == 1.0
    assert "Scan complete: the whole area was scanned, 1 possible person was found" in flight.texts()
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader) == Verification(len(flight.recorder.steps), None)


@virtual
async def test_where_the_look_comes_first_by_what_it_gains_some_look_and_the_others_scan_on() -> None:
    flight = split_flight(search=SearchSettings(split=True, looks=LookOrder.GAIN))
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert len(steps_of(flight, Group.SCAN)) > 3
    assert any("the whole area was scanned" in text for text in flight.texts())
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_behind_the_look_those_who_looked_fly_after_the_others_who_scan_on_until_one_line_forms() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_catching_up(flight))
        looking, scanning = vehicles_of(flight, Group.LOOK), vehicles_of(flight, Group.SCAN)
        left_m = min(norths_m(flight, scanning)) - max(norths_m(flight, looking))
        rounds = len(steps_of(flight, Group.SCAN))
        assert left_m > NEAR_M
        await flight.until(lambda: flight.mission.phase is Phase.LINE)
        assert min(norths_m(flight, looking)) > max(norths_m(flight, scanning)) - NEAR_M - 6.0
        assert len(steps_of(flight, Group.SCAN)) > rounds
        leg, scanned_m = flight.mission.sortie.search.decider.progress.present_leg, reached_m(flight)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        everyone_m = norths_m(flight, looking | scanning)
        assert everyone_m == pytest.approx([leg.start_enu_m[1] + scanned_m] * 8, abs=1.0)
        await flight.commands.act(Action.ABORT, None)
        await run


@virtual
@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND, Action.ABORT])
async def test_every_end_brings_both_groups_down(action: Action) -> None:
    flight = split_flight()
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        watch = group.create_task(flight.watch_separation())
        await flight.until(lambda: is_scanned_on(flight))
        await flight.commands.act(action, None)
        await run
        watch.cancel()
    assert [flight.task(number) for number in range(1, 9)] == [Task.LANDED] * 8
    assert flight.smallest_m >= UNLIMITED.separation_m


def drain(vehicle: FakeVehicle) -> None:
    vehicle.battery_fraction = 0.1


@virtual
@pytest.mark.parametrize("strike", [take_over, lose, drain])
async def test_both_groups_go_on_without_vehicles_that_leave(strike: Callable[[FakeVehicle], None]) -> None:
    flight = split_flight(9)
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        watch = group.create_task(flight.watch_separation())
        await flight.until(lambda: is_scanned_on(flight))
        struck = [min(vehicles_of(flight, one)) for one in Group]
        for number in struck:
            strike(flight.fleet.members[number])
        commands = {number: len(flight.fleet.members[number].commands) for number in struck}
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        for number in struck:
            vehicle = flight.fleet.members[number]
            if strike is not drain:
                assert not any(isinstance(command, Goto) for command in vehicle.commands[commands[number] :])
                vehicle.silent_since_s = None
                vehicle.reclaim()
                await flight.commands.act(Action.LAND, (number,))
        assert await run is Outcome.FOUND
        watch.cancel()
    assert any("the whole area was scanned" in text for text in flight.texts())
    assert flight.smallest_m >= UNLIMITED.separation_m


@virtual
async def test_with_too_few_left_to_look_all_look_and_the_leg_goes_on_where_the_look_began() -> None:
    flight = split_flight(search=SearchSettings(split=True, look_vehicles=2))
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        decider = flight.mission.sortie.search.decider
        split, scanned_m = decider.split, reached_m(flight)
        assert split is not None
        drain(flight.fleet.members[min(split.look_ids)])
        await flight.until(lambda: decider.split is not split)
        assert reached_m(flight) == split.began_m < scanned_m
        assert await run is Outcome.FOUND
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_where_something_else_is_in_view_the_others_wait_and_the_line_forms_there(tmp_path: Path) -> None:
    flight = split_flight()
    for vehicle in flight.fleet.members.values():
        vehicle.others = ((-4.0, 80.0, 24.0),)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert waits(flight)[0].startswith("something is in view at -4.")
    assert any(text.startswith("Finding 2 at -3.9 m east, 79.7 m north") for text in flight.texts())
    assert any("the whole area was scanned" in text for text in flight.texts())
    write_search(tmp_path / "mission", flight.recorder)
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader).difference is None


@virtual
async def test_the_others_may_end_the_last_leg_just_as_the_look_ends() -> None:
    flight = split_flight(flight=FlightSettings(33.0, 2.3))
    for vehicle in flight.fleet.members.values():
        vehicle.others = ((-4.0, 80.0, 24.0),)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND


@virtual
async def test_at_the_end_of_the_leg_the_others_wait_and_the_search_ends_with_the_look() -> None:
    short = (*AREA[:2], (15.0, 62.0), (-15.0, 62.0))
    flight = split_flight(area_enu_m=short)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert waits(flight) == ["they are at the end of the leg"]
    following = [record.following for _, record in sorted(flight.recorder.conclusions.items())]
    assert following[-1] is Phase.RETURN
    assert "Scan complete: the whole area was scanned, 1 possible person was found" in flight.texts()
    assert flight.view.snapshot().covered_fraction == 1.0


def test_where_the_leg_ends_while_the_look_catches_up_the_next_one_begins(tmp_path: Path) -> None:
    wide = ((-32.0, 10.0), (32.0, 10.0), (32.0, 115.0), (-32.0, 115.0))

    async def fly() -> Flight:
        flight = split_flight(target=(-16.0, 40.0), area_enu_m=wide)
        async with flying(flight) as run:
            await flight.until(lambda: is_catching_up(flight))
            leg = flight.mission.sortie.search.decider.progress.leg
            await flight.until(lambda: flight.mission.phase is Phase.LINE)
            assert flight.mission.sortie.search.decider.progress.leg == leg + 1
            assert await run is Outcome.FOUND
        write_search(tmp_path / "mission", flight.recorder)
        return flight

    flight = run_virtually(fly())
    assert waits(flight) == ["they are at the end of the leg"]
    assert flight.view.snapshot().covered_fraction == 1.0
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader) == Verification(len(flight.recorder.steps), None)


@virtual
async def test_before_a_zone_the_others_wait() -> None:
    zone = ((-30.0, 48.0), (30.0, 48.0), (30.0, 54.0), (-30.0, 54.0))
    very_long = replace(LONG_LOOK, hold_steps=30)
    flight = split_flight(safety=SafetyOverrides(no_go_enu_m=(zone,), margin_m=1.0), detection=very_long)
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        watch = group.create_task(flight.watch_separation())
        await flight.until(lambda: bool(waits(flight)))
        await flight.clock.sleep(2.0)
        await flight.commands.act(Action.ABORT, None)
        await run
        watch.cancel()
    assert waits(flight) == ["the line cannot sweep on"]
    assert flight.smallest_m >= UNLIMITED.separation_m


@virtual
async def test_without_frames_the_others_wait() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        scanning = vehicles_of(flight, Group.SCAN)
        for number in scanning:
            flight.fleet.members[number].camera_works = False
        await flight.until(lambda: bool(waits(flight)))
        for number in scanning:
            flight.fleet.members[number].camera_works = True
        assert await run is Outcome.FOUND
    assert waits(flight)[0].startswith("no frames (")
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_a_look_without_frames_ends_the_search_in_words_and_brings_both_groups_home() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        for number in vehicles_of(flight, Group.LOOK):
            flight.fleet.members[number].camera_works = False
        await run
    assert any(text.startswith("No camera delivered a usable frame in 3 steps") for text in flight.texts())
    assert [flight.task(number) for number in range(1, 9)] == [Task.LANDED] * 8


@virtual
async def test_where_others_cannot_cover_the_strip_all_look() -> None:
    short, search = (*AREA[:2], (15.0, 50.0), (-15.0, 50.0)), SearchSettings(split=True, line_spacing_m=9.0)
    flight = split_flight(search=search, area_enu_m=short, detection=replace(LONG_LOOK, hold_steps=1))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.FOUND)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert {one.group for one in flight.recorder.decisions.values()} == {None}
    assert any(one.startswith("All vehicles look closely: the others would be 32 m apart") for one in flight.texts())
