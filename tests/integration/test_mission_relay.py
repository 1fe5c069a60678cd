"""Relays of batteries on the fake fleet, in virtual time: who leaves, who takes off, and who must not."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.errors import MissionError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.strength import TAKE_OFF_S
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, FlightSettings, PreflightSettings, RelaySettings
from aos_gcs.ports import Arm, LandedState
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare
from tests.fakes.restarted_flight import killed_while_searching, restarted

pytestmark = pytest.mark.virtual

AREA = ((-8.0, 10.0), (8.0, 10.0), (8.0, 125.0), (-8.0, 125.0))
PER_S = 0.0034
"""Battery that a second in the air costs: from 90 % down to the reserve in 206 s."""
SWAP_S = 5.0


def relayed(relay: RelaySettings, *, n: int = 2, is_simulated: bool = False) -> Flight:
    """Return a slow search of few frames, with one vehicle beside those that search."""
    flight = prepare(
        n,
        None,
        errors=EXACT,
        camera_delay_s=2.0,
        imaging=ImagingSettings(rx_quantile=0.998, rate_hz=0.2),
        area_enu_m=AREA,
        search=SearchSettings(SearchMode.CONTINUOUS),
        flight=FlightSettings(lowest_layer_m=12.0, search_speed_mps=0.5),
        deadlines=Deadlines(connect_s=5.0, preflight_s=15.0, capture_s=5.0, transfer_s=60.0, land_s=60.0),
        preflight=PreflightSettings(upload_fence=True, set_return_height=True),
        relay=relay,
        any_vehicles=is_simulated,
        vehicle_ids=() if is_simulated else tuple(range(1, n + 1)),
    )
    flight.fleet.members[n + 1] = FakeVehicle(n + 1, flight.clock, np.array([20.0, -3.0, 0.0]), None)
    return flight


async def searching(flight: Flight) -> None:
    await flight.until(lambda: len(flight.view.steps()) > 2)


def is_flying(vehicle: FakeVehicle) -> bool:
    return vehicle.armed and vehicle.state.landed is LandedState.IN_AIR


async def use_batteries(flight: Flight, swap_s: float = SWAP_S) -> None:
    """Drain the batteries of those that fly, and change those of vehicles that have come down for good."""
    down_s: dict[int, float] = {}
    while True:
        for number, vehicle in flight.fleet.members.items():
            if is_flying(vehicle):
                down_s[number] = 0.0
                vehicle.battery_fraction -= PER_S
            elif number in down_s and not vehicle.armed:
                down_s[number] += 1.0
                if down_s[number] >= swap_s:
                    vehicle.battery_fraction = 0.95
        await flight.clock.sleep(1.0)


def took_off(flight: Flight, number: int) -> int:
    return sum(isinstance(command, Arm) for command in flight.fleet.members[number].commands)


@pytest.mark.slow
async def test_batteries_are_relayed_and_the_line_never_stops_for_it() -> None:
    flight = relayed(RelaySettings(enabled=True, swap_s=SWAP_S), is_simulated=True)
    lines, lowest = [], []

    async def watch() -> None:
        while True:
            snapshot = flight.view.snapshot()
            if snapshot.phase in {"scan", "line"} and snapshot.elapsed_s > 40.0:
                lines.append(sum(one.task is Task.SWARM for one in snapshot.vehicles))
            lowest.extend(one.battery_fraction for one in flight.fleet.members.values() if is_flying(one))
            await flight.clock.sleep(1.0)

    async with flying(flight) as run, asyncio.TaskGroup() as group:
        helpers = [group.create_task(one) for one in (use_batteries(flight), watch(), flight.watch_separation())]
        assert await run is Outcome.NOT_FOUND
        for helper in helpers:
            helper.cancel()
    texts = flight.texts()
    assert flight.journal.elapsed_s() > 0.7 / PER_S, "the search outlasts a battery"
    assert "Scan complete: the whole area was scanned, nothing was found" in texts
    assert min(lines) == 2
    assert sum("takes its place" in text for text in texts) >= 2
    assert not any("and 20% must be left" in text for text in texts), "nobody leaves without being relieved"
    assert min(lowest) >= UNLIMITED.min_battery_fraction
    assert flight.smallest_m >= UNLIMITED.separation_m
    assert flight.view.snapshot().covered_fraction == 1.0


async def test_a_named_vehicle_takes_off_once_and_again_only_when_it_is_confirmed() -> None:
    flight = relayed(RelaySettings(enabled=True, vehicle_ids=(4,), swap_s=SWAP_S), n=3)
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        batteries = group.create_task(use_batteries(flight))
        await searching(flight)
        flight.fleet.members[1].battery_fraction = 0.4
        await flight.until(lambda: any(flight.task(key) is Task.LANDED for key in (1, 2, 3)))
        relieved = next(key for key in (1, 2, 3) if flight.task(key) is Task.LANDED)
        await flight.until(lambda: flight.task(4) is Task.SWARM)
        snapshot = flight.view.snapshot().vehicles[relieved - 1]
        assert snapshot.is_ready is False
        await flight.clock.sleep(SWAP_S + 15.0)
        assert (flight.task(relieved), took_off(flight, relieved)) == (Task.LANDED, 1), "people may stand beside it"
        (result,) = await flight.commands.act(Action.READY, (relieved,), operator="Robin")
        assert (result.accepted, result.text) == (True, "may take off once, to relieve another vehicle")
        await flight.clock.sleep(0.1)
        assert f"Robin: vehicle {relieved} is ready to relieve others" in flight.texts()
        await flight.until(lambda: took_off(flight, relieved) == 2)
        await flight.commands.act(Action.ABORT, None)
        await run
        batteries.cancel()


async def test_confirmations_are_refused_where_they_mean_nothing_and_can_be_taken_back() -> None:
    flight = relayed(RelaySettings(), n=3)
    async with flying(flight) as run:
        await searching(flight)
        with pytest.raises(MissionError, match="each is confirmed on its own"):
            await flight.commands.act(Action.READY, None)
        (result,) = await flight.commands.act(Action.READY, (1,))
        assert (result.accepted, result.text) == (False, "is not on the ground with stopped motors")
        assert (await flight.commands.act(Action.READY, (4,)))[0].accepted
        assert flight.view.snapshot().vehicles[3].is_ready is True
        assert (await flight.commands.act(Action.NOT_READY, (4,)))[0].accepted
        flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        await flight.clock.sleep(15.0)
        assert took_off(flight, 4) == 0
        (result,) = await flight.commands.act(Action.NOT_READY, (1,))
        assert "has taken off" in result.text
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_after_a_restart_in_flight_vehicles_that_the_plan_names_are_confirmed_anew() -> None:
    relay = RelaySettings(enabled=True, vehicle_ids=(4,))
    former = prepare(3, None, errors=EXACT)
    last = await killed_while_searching(former, steps=1)
    flight = restarted(last, errors=EXACT, target=None, relay=relay)
    flight.fleet.members[4] = FakeVehicle(4, flight.clock, np.array([20.0, -3.0, 0.0]), None)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        await flight.clock.sleep(1.0)
        assert flight.view.snapshot().vehicles[3].is_ready is False, "people may be changing its battery"
        assert (await flight.commands.act(Action.READY, (4,)))[0].accepted
        assert flight.view.snapshot().vehicles[3].is_ready is True
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_nobody_takes_off_while_all_are_held_and_the_gap_of_one_lost_on_its_way_home_is_filled_then() -> None:
    flight = relayed(RelaySettings(enabled=True, vehicle_ids=(4,), swap_s=SWAP_S), n=3)
    async with flying(flight) as run:
        await searching(flight)
        await flight.commands.act(Action.HOLD, None)
        flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: flight.task(2) is Task.RETURNING)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.task(2) is Task.LOST)
        await flight.clock.sleep(15.0)
        assert took_off(flight, 4) == 0
        await flight.commands.act(Action.RESUME, None)
        await flight.until(lambda: flight.task(4) is Task.SWARM)
        flight.fleet.members[2].silent_since_s = None
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_replacement_without_a_new_battery_stays_on_the_ground_and_says_why() -> None:
    flight = relayed(RelaySettings(enabled=True, vehicle_ids=(4,), swap_s=SWAP_S), n=3)
    flight.fleet.members[4].battery_fraction = 0.3
    async with flying(flight) as run:
        await searching(flight)
        flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        await flight.clock.sleep(15.0)
        told = [text for text in flight.texts() if "cannot take off for the relay" in text]
        assert len(told) == 1
        assert "replace the battery" in told[0]
        assert took_off(flight, 4) == 0
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_swarm_that_is_too_small_waits_for_its_replacement_and_the_search_goes_on() -> None:
    flight = relayed(RelaySettings(enabled=True, vehicle_ids=(3,), swap_s=SWAP_S))
    async with flying(flight) as run:
        await searching(flight)
        flight.fleet.members[1].battery_fraction = 0.1
        await flight.until(lambda: flight.view.snapshot().message == "Waiting for a replacement: 1 left in the swarm.")
        await flight.clock.sleep(2.0)
        assert not flight.fleet.members[2].is_moving(), "it does not fly on alone"
        await flight.until(lambda: flight.task(3) is Task.SWARM)
        steps = len(flight.view.steps())
        await flight.until(lambda: len(flight.view.steps()) > steps + 1)
        assert flight.mission.phase in {Phase.SCAN, Phase.LINE}
        await flight.commands.act(Action.RETURN, None)
        assert await run is Outcome.NOT_FOUND


async def test_a_relay_that_cannot_keep_up_ends_the_search_for_its_batteries_and_does_not_fail() -> None:
    flight = relayed(RelaySettings(enabled=True, vehicle_ids=(3,), swap_s=SWAP_S))
    flight.fleet.members[3].battery_fraction = 0.3
    async with flying(flight) as run:
        await searching(flight)
        flight.fleet.members[1].battery_fraction = 0.1
        await flight.until(lambda: flight.task(1) is Task.RETURNING)
        left_at_s = flight.clock.now_s()
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        assert SWAP_S < flight.clock.now_s() - left_at_s < SWAP_S + TAKE_OFF_S + 10.0
        assert await run is Outcome.NOT_FOUND
    (text,) = (text for text in flight.texts() if text.startswith("Search ended by the batteries"))
    assert "1 left in the swarm, 2 needed (vehicle 1: battery at 10%)" in text
    assert [flight.task(number) for number in (1, 2)] == [Task.LANDED] * 2
    assert not any("The swarm needs" in text for text in flight.texts())
