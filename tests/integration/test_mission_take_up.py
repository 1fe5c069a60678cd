"""A flight whose station was killed, taken up by the station that follows it, in virtual time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.config.file import parse_config
from aos_gcs.errors import LinkError, MissionError
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import FlightSettings, PreflightSettings, RelaySettings
from aos_gcs.ports import DriverContext, Fleet, FlightMode, FormerLinks, Goto, ProvenLink
from aos_gcs.runtime.service import open_service
from aos_gcs.runtime.simulated import virtual_time
from aos_gcs.store.last_mission import former_flight
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare, settings
from tests.fakes.records import snapshot
from tests.fakes.restarted_flight import killed_while_searching, restarted

BIASED = {"bias_m": (0.01, 2.0)}
"""Each vehicle's altitudes err by a constant."""
UNCHECKED = PreflightSettings(upload_fence=True, overrides={"home altitude": "a test", "altitude accuracy": "a test"})


@pytest.fixture(scope="module")
def last() -> MissionSnapshot:
    """The last state on record of a station that was killed while it searched."""

    async def fly() -> MissionSnapshot:
        return await killed_while_searching(prepare(3, errors=BIASED, preflight=UNCHECKED), steps=2)

    return virtual_time.run(fly())


def follow(last: MissionSnapshot, **changes: object) -> Flight:
    return restarted(last, **{"errors": BIASED, "preflight": UNCHECKED, **changes})


async def until_taken_up(flight: Flight) -> None:
    await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
    await flight.clock.sleep(1.0)


@pytest.mark.virtual
@pytest.mark.parametrize("is_confirmed_since", [False, True])
async def test_a_spare_of_the_relay_outside_of_the_launch_points_leaves_the_limits_known(
    is_confirmed_since: bool,
) -> None:
    relay = RelaySettings() if is_confirmed_since else RelaySettings(enabled=True, vehicle_ids=(4,))
    flown = {"relay": relay, "any_vehicles": False, "vehicle_ids": (1, 2, 3)}
    flight = prepare(3, None, **flown)
    flight.fleet.members[4] = FakeVehicle(4, flight.clock, np.array([30.0, -6.0, 0.0]), None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        if is_confirmed_since:
            await flight.commands.act(Action.READY, (4,))
        last, limits = flight.view.snapshot(), flight.mission.sortie.context.bounds.limits
        await flight.commands.act(Action.ABORT, None)
        await run
    former = FormerFlight(last, None, 0.0)
    taken_up = former.limits(former.settings(settings(3, **flown)))
    assert limits is not None
    assert taken_up is not None
    assert np.allclose(taken_up.fence_enu_m, limits.fence_enu_m, atol=0.01)
    assert taken_up.ceiling_m == pytest.approx(limits.ceiling_m)
    assert (
        former.limits(replace(former.settings(settings(3, **flown)), area_enu_m=((0.0, 0.0), (9.0, 0.0), (0.0, 9.0))))
        is None
    )


@pytest.mark.virtual
async def test_vehicles_keep_their_layers_and_limits_and_wait_for_an_operator(last: MissionSnapshot) -> None:
    flight = follow(last)
    async with flying(flight) as run:
        await until_taken_up(flight)
        await flight.clock.sleep(60.0)
        now = flight.view.snapshot()
        assert (now.phase, now.suspension) == (Phase.TAKEOFF, Suspension.HELD)
        assert now.elapsed_s > last.elapsed_s + 60.0
        assert [one.layer_height_m for one in now.vehicles] == [one.layer_height_m for one in last.vehicles]
        assert [one.home_enu_m for one in now.vehicles] == [one.home_enu_m for one in last.vehicles]
        assert (now.fence_enu_m, now.legs_enu_m, now.leg) == (last.fence_enu_m, last.legs_enu_m, last.leg)
        assert [one.task for one in now.vehicles] == [Task.HELD] * 3
        assert not any(vehicle.commands for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert [flight.task(number) for number in (1, 2, 3)] == [Task.LANDED] * 3


@pytest.mark.virtual
@pytest.mark.parametrize("action", [Action.RETURN, Action.LAND])
async def test_they_are_brought_down_apart(last: MissionSnapshot, action: Action) -> None:
    flight = follow(last)
    async with flying(flight) as run:
        watch = asyncio.create_task(flight.watch_separation())
        await until_taken_up(flight)
        offsets_m = [member.altitude_offset_m for member in flight.mission.sortie.context.roster.members()]
        assert max(offsets_m) - min(offsets_m) > 1.0
        await flight.commands.act(action, None)
        await run
        watch.cancel()
    now = flight.view.snapshot()
    assert [one.task for one in now.vehicles] == [Task.LANDED] * 3
    assert flight.smallest_m >= 1.5
    if action is Action.RETURN:
        for vehicle in flight.fleet.members.values():
            gotos = [command for command in vehicle.commands if isinstance(command, Goto)]
            assert gotos, "led home in its layer, not by its autopilot"


@pytest.mark.virtual
async def test_one_heard_later_is_attached_too_and_one_in_its_failsafe_is_left_to_it(last: MissionSnapshot) -> None:
    flight = follow(last)
    late = flight.fleet.members.pop(2)
    flight.fleet.members[3].mode = FlightMode.RETURN
    async with flying(flight) as run:
        await until_taken_up(flight)
        flight.fleet.members[2] = late
        await flight.until(lambda: len(flight.view.snapshot().vehicles) == 3 and flight.task(2) is Task.HELD)
        assert flight.view.snapshot().vehicles[1].layer_height_m == last.vehicles[1].layer_height_m
        results = {one.vehicle_id: one.accepted for one in await flight.commands.act(Action.RESUME, None)}
        assert results == {1: True, 2: True, 3: False}
        await flight.clock.sleep(5.0)
        assert not flight.fleet.members[3].commands
        await flight.commands.act(Action.RETURN, None)
        await run


@pytest.mark.virtual
async def test_one_that_a_pilot_holds_in_a_mode_of_ours_stays_with_the_pilot_until_it_is_resumed_alone(
    last: MissionSnapshot,
) -> None:
    reason = "its mode changed to LOITER"
    first, *others = last.vehicles
    piloted = replace(first, telemetry=replace(first.telemetry, taken_over=reason, has_pilot=True))
    flight = follow(replace(last, vehicles=(piloted, *others)))
    vehicle = flight.fleet.members[1]
    async with flying(flight) as run:
        await until_taken_up(flight)
        await flight.commands.act(Action.HOLD, None)
        results = {one.vehicle_id: one for one in await flight.commands.act(Action.RESUME, None)}
        assert [results[number].accepted for number in (1, 2, 3)] == [False, True, True]
        assert reason in results[1].text
        await flight.clock.sleep(1.0)
        assert not vehicle.commands
        (result,) = await flight.commands.act(Action.RESUME, (1,))
        assert result.accepted, result.text
        await flight.until(lambda: any(isinstance(command, Goto) for command in vehicle.commands))
        await flight.commands.act(Action.LAND, None)
        await run


@pytest.mark.virtual
async def test_a_landing_that_a_pilot_has_begun_before_is_not_stopped_by_a_hold_for_all(last: MissionSnapshot) -> None:
    first, *others = last.vehicles
    piloted = replace(first, telemetry=replace(first.telemetry, taken_over="its mode changed to LAND", has_pilot=True))
    flight = follow(replace(last, vehicles=(piloted, *others)))
    vehicle = flight.fleet.members[1]
    vehicle.mode = FlightMode.LAND
    async with flying(flight) as run:
        await until_taken_up(flight)
        results = {one.vehicle_id: one.accepted for one in await flight.commands.act(Action.HOLD, None)}
        assert results == {1: False, 2: True, 3: True}
        assert not vehicle.commands
        for action in (Action.LAND, Action.HOLD):
            (result,) = await flight.commands.act(action, (1,))
            assert result.accepted, result.text
        await flight.commands.act(Action.LAND, None)
        await run


@pytest.mark.virtual
async def test_resume_is_refused_while_all_are_in_failsafes_and_possible_when_they_come_back(
    last: MissionSnapshot,
) -> None:
    flight = follow(last)
    vehicles = flight.fleet.members.values()
    for vehicle in vehicles:
        vehicle.failsafe = "battery"
    async with flying(flight) as run:
        await until_taken_up(flight)
        for still_out, flying_by in ((3, 0), (2, 1)):
            with pytest.raises(
                MissionError, match=rf"Cannot resume.*and has {flying_by} .*failsafe is active \(battery"
            ) as raised:
                await flight.commands.act(Action.RESUME, None)
            assert str(raised.value).count("failsafe is active") == still_out
            assert (flight.mission.phase, flight.view.snapshot().suspension) == (Phase.TAKEOFF, Suspension.HELD)
            flight.fleet.members[still_out].failsafe = ""
            await flight.clock.sleep(1.0)
        results = {one.vehicle_id: one.accepted for one in await flight.commands.act(Action.RESUME, None)}
        assert results == {1: False, 2: True, 3: True}
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.virtual
async def test_a_changed_plan_is_not_flown_on_by_and_landed_vehicles_are_no_flight(last: MissionSnapshot) -> None:
    changed = follow(replace(last, area_enu_m=((0.0, 0.0), (9.0, 0.0), (9.0, 9.0))), auto_start=False)
    async with flying(changed) as run:
        await changed.until(lambda: any("cannot be taken up" in text for text in changed.texts()))
        assert changed.mission.phase in {Phase.CONNECT, Phase.PREFLIGHT}
        await changed.commands.act(Action.ABORT, None)
        await run
    landed = prepare(3, former=FormerFlight(last, None, 0.0), flight=FlightSettings(lowest_layer_m=31.0))
    async with flying(landed) as run:
        await landed.until(lambda: landed.mission.phase is Phase.SCAN)
        assert [one.layer_height_m for one in landed.view.snapshot().vehicles] == [31.0, 33.5, 36.0]
        await landed.commands.act(Action.ABORT, None)
        await run


@pytest.mark.virtual
async def test_one_that_was_still_climbing_climbs_straight_into_its_layer(last: MissionSnapshot) -> None:
    flight = follow(last)
    low = flight.fleet.members[1]
    low.start_enu_m = low.goal_enu_m = low.home_enu_m + np.array([0.0, 0.0, 8.0])
    async with flying(flight) as run:
        await until_taken_up(flight)
        await flight.commands.act(Action.RESUME, None)
        await flight.until(low.is_moving)
        reported_m = 35.0 + last.vehicles[0].altitude_offset_m
        assert low.goal_enu_m == pytest.approx([*low.home_enu_m[:2], reported_m], abs=0.1)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize(
    ("changes", "ends", "age_s", "is_found"),
    [
        ({}, False, 60.0, True),
        ({}, True, 60.0, False),
        ({}, False, 7200.0, False),
        ({"phase": Phase.READY}, False, 60.0, False),
    ],
    ids=["killed in flight", "ended", "long ago", "killed before the start"],
)
async def test_only_an_unfinished_flight_of_late_is_read_back(
    tmp_path: Path, changes: dict[str, Phase], ends: bool, age_s: float, is_found: bool
) -> None:
    proven = (ProvenLink("0 10.0.0.1 14550", "ab12", 75.5, is_signed=True),)
    first, *others = snapshot().vehicles
    first = replace(first, telemetry=replace(first.telemetry, proven=proven))
    last = replace(snapshot(), vehicles=(first, *others), **changes)
    async with MissionRecorder.create(tmp_path, "m", {}, notify=lambda _: None) as recorder:
        await recorder.record_event(Event(1, 1000.0, EventKind.SNAPSHOT, last))
        if ends:
            await recorder.record_outcome(OutcomeRecord(1000.0, Outcome.FOUND, {}))
    found = former_flight(tmp_path, 1000.0 + age_s)
    assert (found is not None) is is_found
    assert found is None or found.last == last
    assert found is None or found.links == FormerLinks(1000.0, {first.telemetry.vehicle_id: proven})


@pytest.mark.usefixtures("threaded_workers")
async def test_the_driver_learns_where_vehicles_of_a_killed_flight_were_heard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    contexts = []

    @asynccontextmanager
    async def refuse(_links: Sequence[str], context: DriverContext) -> AsyncIterator[Fleet]:
        contexts.append(context)
        raise LinkError("nothing is opened here")
        yield

    now_s, proven = time.time(), (ProvenLink("0 10.0.0.1 14550", "ab12", 75.5),)
    first, *others = snapshot().vehicles
    flown = replace(snapshot(), vehicles=(replace(first, telemetry=replace(first.telemetry, proven=proven)), *others))
    async with MissionRecorder.create(tmp_path, "1-killed", {}, notify=lambda _: None) as recorder:
        await recorder.record_event(Event(1, now_s, EventKind.SNAPSHOT, flown))
    monkeypatch.setattr("aos_gcs.runtime.service.load_driver", lambda _: refuse)
    tables = {
        "link": {"urls": ["udpin://127.0.0.1:14550"]},
        "mission": {"area_enu_m": [[0, 0], [9, 0], [9, 9]], "vehicle_ids": [1, 2]},
        "api": {"enabled": False},
        "record": {"folder": tmp_path},
    }
    with pytest.raises(LinkError):
        async with open_service(parse_config(tables, source="test")):
            pass
    assert [context.former for context in contexts] == [FormerLinks(now_s, {first.telemetry.vehicle_id: proven})]
