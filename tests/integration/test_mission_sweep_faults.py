"""Faults in the middle of a sweep, when vehicles fly towards places far ahead. In virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import ParamSpec, TypeVar

import numpy as np
import pytest

from aos_gcs.airspace.stopping import DECELERATION_MPS2
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.in_flight.commands import ANALYSIS_S, SweepCommands
from aos_gcs.mission.search.in_flight.exposing import BLIND_S
from aos_gcs.mission.search.scan.sweep import LEFT_BEHIND_M
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Command, FlightMode, Goto, Hold, ReturnToLaunch
from aos_gcs.ports.worker import ThreadWorker
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare
from tests.fakes.restarted_flight import restarted

P = ParamSpec("P")
T = TypeVar("T")

virtual = pytest.mark.virtual

STOPS_AFTER_S = BLIND_S + ANALYSIS_S
SPEED_MPS = FlightSettings().leg_speed_mps
AREA = ((-8.0, 10.0), (8.0, 10.0), (8.0, 110.0), (-8.0, 110.0))


class HangingWorker(ThreadWorker):
    """Analyses nothing for some seconds, once."""

    def __init__(self) -> None:
        self.hangs_s = 0.0

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        hangs_s, self.hangs_s = self.hangs_s, 0.0
        await asyncio.sleep(hangs_s)
        return await super().run(function, *args, **kwargs)


def sweep_flight(n: int = 3, **changes: object) -> Flight:
    search = SearchSettings(SearchMode.CONTINUOUS)
    return prepare(n, None, search=search, area_enu_m=AREA, camera_delay_s=0.6, errors=EXACT, **changes)


def is_in_the_middle(flight: Flight) -> bool:
    return sum(step.branch == "sweep" for step in flight.view.steps()) >= 5


def north_m(flight: Flight, vehicle_id: int) -> float:
    return float(flight.fleet.members[vehicle_id].position_enu_m()[1])


def commands(flight: Flight, vehicle_id: int) -> list[type[Command]]:
    return [type(command) for command in flight.fleet.members[vehicle_id].commands]


@virtual
async def test_while_no_image_is_analysed_the_line_stops_and_then_flies_on() -> None:
    worker = HangingWorker()
    flight = sweep_flight(worker=worker)
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        worker.hangs_s, begun_m = 14.0, north_m(flight, 2)
        await flight.clock.sleep(STOPS_AFTER_S + 3.0)
        stopped_m = north_m(flight, 2)
        assert stopped_m - begun_m <= SPEED_MPS * (STOPS_AFTER_S + 2.0) + SPEED_MPS**2 / (2.0 * DECELERATION_MPS2)
        await flight.clock.sleep(4.0)
        assert north_m(flight, 2) == pytest.approx(stopped_m, abs=0.01)
        await flight.until(lambda: north_m(flight, 2) > stopped_m + 20.0)
        assert flight.mission.phase is Phase.SCAN
        await flight.commands.act(Action.RETURN, None)
        await run
    assert sum(text.endswith("the line stops until it is over") for text in flight.texts()) == 1


@virtual
async def test_a_vehicle_that_confirms_nothing_delays_no_other() -> None:
    flight = sweep_flight()
    confirm_nothing(flight.fleet.members[1])
    slow_down(flight.fleet.members[2])
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        await flight.clock.sleep(8.0)
        # The third one was told to wait for the second, although the first has not confirmed its own waypoint.
        assert north_m(flight, 3) - north_m(flight, 2) < LEFT_BEHIND_M
        await flight.commands.act(Action.LAND, None)
        await run
    assert not any("superseded" in text or "behind the line" in text for text in flight.texts())


def slow_down(vehicle: FakeVehicle) -> None:
    """Have it fly at half the speed of the line, as against the wind."""
    execute = vehicle.execute

    async def slowly(command: Command, deadline_s: float) -> None:
        await execute(command, deadline_s)
        vehicle.speed_mps = min(vehicle.speed_mps, SPEED_MPS / 2.0)

    object.__setattr__(vehicle, "execute", slowly)


def confirm_nothing(vehicle: FakeVehicle) -> None:
    """Have it do what it is told in flight, while its acknowledgements are lost."""
    execute = vehicle.execute

    async def mute(command: Command, deadline_s: float) -> None:
        await execute(command, deadline_s)
        if isinstance(command, Goto) and command.speed_mps == SPEED_MPS:
            await vehicle.clock.sleep(deadline_s - vehicle.clock.now_s())

    object.__setattr__(vehicle, "execute", mute)


@virtual
async def test_a_vehicle_whose_position_is_not_known_any_more_stops_instead_of_flying_to_the_front() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        vehicle = flight.fleet.members[3]
        frozen_at_s, compute = flight.clock.now_s(), vehicle._compute_state
        object.__setattr__(vehicle, "_compute_state", lambda: replace(compute(), position_at_s=frozen_at_s))
        await flight.clock.sleep(5.0)
        assert commands(flight, 3)[-1] is Hold
        assert not vehicle.is_moving()
        assert commands(flight, 2)[-1] is Goto
        object.__setattr__(vehicle, "_compute_state", compute)
        await flight.clock.sleep(2.0)
        assert commands(flight, 3)[-1] is Goto
        await flight.commands.act(Action.RETURN, None)
        await run


def bar(flight: Flight, monkeypatch: pytest.MonkeyPatch, vehicle_id: int) -> Callable[[], None]:
    """Hold a vehicle that is on its way home at each look at its path; return what frees it."""
    control, barred = flight.mission.sortie.context.flight, {vehicle_id}
    vet = control.vet

    def bar_way_home(
        requests: Mapping[int, np.ndarray], *arguments: object, returning: bool = False
    ) -> tuple[WaypointRecord, ...]:
        return tuple(
            replace(one, sent_enu_m=None, verdict=WaypointVerdict.HELD, reason="held: the way is barred")
            if returning and one.vehicle_id in barred
            else one
            for one in vet(requests, *arguments, returning=returning)  # type: ignore[arg-type]
        )

    monkeypatch.setattr(control, "vet", bar_way_home)
    return barred.clear


@virtual
@pytest.mark.parametrize("is_ordered_for_all", [True, False])
async def test_one_whose_way_home_is_barred_stops_instead_of_flying_to_the_front_and_goes_home_once_it_is_free(
    monkeypatch: pytest.MonkeyPatch, is_ordered_for_all: bool
) -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        free, begun_m = bar(flight, monkeypatch, 3), north_m(flight, 3)
        await flight.commands.act(Action.RETURN, None if is_ordered_for_all else (3,))
        await flight.clock.sleep(6.0)
        assert north_m(flight, 3) - begun_m <= SPEED_MPS + SPEED_MPS**2 / (2.0 * DECELERATION_MPS2)
        assert not flight.fleet.members[3].is_moving()
        assert commands(flight, 3).count(Hold) == 1
        assert (flight.task(3), flight.fleet.members[3].mode) == (Task.RETURNING, FlightMode.HOLD)
        free()
        await flight.until(lambda: flight.task(3) is Task.LANDED)
        if not is_ordered_for_all:
            await flight.commands.act(Action.RETURN, None)
        await run
    barred = "must not fly on towards home now, so it hovers and tries again (held: the way is barred)"
    assert flight.texts().count(barred) == 1
    assert np.hypot(*flight.fleet.members[3].position_enu_m()[:2]) < 30.0
    assert ReturnToLaunch not in commands(flight, 3)


@virtual
async def test_one_on_its_way_home_that_must_not_be_sent_on_flies_on_and_counts_as_held_by_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        control = flight.mission.sortie.context.flight
        held = [
            WaypointRecord(number, (0.0, 0.0, 30.0), None, WaypointVerdict.HELD, "held: no position", is_unfit=True)
            for number in (2, 3)
        ]
        flight.fleet.members[3].battery_fraction = 0.1
        await flight.until(lambda: flight.task(3) is Task.RETURNING and commands(flight, 3)[-1] is Goto)
        await flight.until(flight.fleet.members[3].is_moving)
        assert control.orders(held, frozenset({Task.SWARM, Task.RETURNING})) == {2: Hold()}
        bar(flight, monkeypatch, 1)
        flight.fleet.members[1].battery_fraction = 0.1
        await flight.until(lambda: flight.task(1) is Task.RETURNING and commands(flight, 1)[-1] is Hold)
        (member,) = flight.mission._context.roster.select([1])
        assert not member.is_held_by_order
        await flight.commands.act(Action.HOLD, None)
        assert member.is_held_by_order
        await flight.commands.act(Action.LAND, None)
        await run


@virtual
async def test_one_that_is_paused_alone_stops_and_the_others_sweep_on() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        (result,) = await flight.commands.act(Action.PAUSE, (3,))
        assert result.accepted
        paused_m, others_m = north_m(flight, 3), north_m(flight, 2)
        await flight.clock.sleep(5.0)
        assert north_m(flight, 3) == pytest.approx(paused_m, abs=0.5)
        assert north_m(flight, 2) > others_m + 15.0
        await flight.commands.act(Action.RESUME, (3,))
        assert flight.task(3) is Task.SWARM
        assert await run is Outcome.NOT_FOUND


@virtual
async def test_one_of_two_that_is_paused_alone_is_waited_for_and_nobody_flies_home() -> None:
    flight = sweep_flight(2)
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        await flight.commands.act(Action.PAUSE, (2,))
        await flight.clock.sleep(10.0)
        assert flight.mission.phase is Phase.SCAN
        assert flight.view.snapshot().message == "Waiting for 1 held vehicles: resume them, or return all."
        assert not any(vehicle.is_moving() for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.RESUME, (2,))
        assert await run is Outcome.NOT_FOUND


@virtual
async def test_a_hold_that_comes_with_new_waypoints_of_the_sweep_is_the_last_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flight, holds = sweep_flight(), list[asyncio.Task[object]]()
    send = SweepCommands.send

    def send_after_hold(sending: SweepCommands, waypoints: Sequence[WaypointRecord]) -> None:
        """Have an operator hold all in the very moment in which everybody is sent on."""
        if is_in_the_middle(flight) and not holds:
            holds.append(asyncio.create_task(flight.commands.act(Action.HOLD, None)))
            sending._unconfirmed |= {1, 2, 3}
        send(sending, waypoints)

    monkeypatch.setattr(SweepCommands, "send", send_after_hold)
    async with flying(flight) as run:
        await flight.until(lambda: bool(holds))
        await flight.clock.sleep(3.0)
        assert [commands(flight, number)[-1] for number in (1, 2, 3)] == [Hold] * 3
        assert [commands(flight, number)[-2] for number in (1, 2, 3)] == [Goto] * 3
        assert not any(vehicle.is_moving() for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.RETURN, None)
        await run


@virtual
async def test_a_station_that_takes_a_sweep_up_reckons_with_where_its_vehicles_still_fly() -> None:
    flight = sweep_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_in_the_middle(flight))
        last = flight.view.snapshot()
        run.cancel()
    again = restarted(last, area_enu_m=AREA, errors=EXACT)
    for former in last.vehicles:
        vehicle = again.fleet.members[former.telemetry.vehicle_id]
        vehicle.speed_mps = SPEED_MPS
        vehicle.fly_to(np.array(former.waypoint_enu_m))
    async with flying(again) as run:
        await again.until(lambda: again.mission.phase is Phase.TAKEOFF)
        flight_control = again.mission.sortie.context.flight
        (member,) = again.mission._context.roster.select([1])
        ahead_m = member.vehicle.position_enu_m() + np.array([0.0, 20.0, 0.0])  # type: ignore[attr-defined]
        above_m, below_m = ahead_m + np.array([0.0, 0.0, 10.0]), ahead_m - np.array([0.0, 0.0, 10.0])
        (other,) = again.mission._context.roster.select([2])
        assert flight_control.blocks_path(other, above_m, below_m, frozenset({3})) == 1
        again.fleet.members[1].fly_to(again.fleet.members[1].position_enu_m())
        assert flight_control.blocks_path(other, above_m, below_m, frozenset({3})) is None
        await again.commands.act(Action.LAND, None)
        await run
