"""Vehicles that return past those that come down at any time, by a pilot or by themselves; virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.ways import WayWatch
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import FlightMode
from tests.fakes.fleet import ORIGIN, FakeFleet
from tests.fakes.roster import give_task

pytestmark = pytest.mark.virtual

SEPARATION_M = 1.5
HOME = np.array([0.0, 0.0, 35.0])
RETURNING = frozenset({Task.RETURNING})


LIMITS = SafetyLimits(
    fence_enu_m=((-99.0, -99.0), (99.0, -99.0), (99.0, 99.0), (-99.0, 99.0)),
    floor_m=20.0,
    ceiling_m=60.0,
    separation_m=SEPARATION_M,
)


class Passing:
    """Vehicle 1 returns in its layer; vehicle 2 is above its path, with a pilot from some time on."""

    def __init__(self, mover: tuple[float, float], other: tuple[float, float]) -> None:
        clock = LoopClock()
        self.fleet = FakeFleet(clock, 2, None)
        roster = Roster(self.fleet, clock)
        roster.refresh()
        roster.frame = LocalFrame(ORIGIN)
        settings, deadlines = FlightSettings(), Deadlines(transfer_s=20.0)
        self.bounds = FlightBounds(settings.arrival_radius_m, LIMITS)
        self.control = FlightControl(roster, clock, Journal(clock), settings, deadlines, bounds=self.bounds)
        self.mover, self.other = self.fleet.members[1], self.fleet.members[2]
        places = zip(roster.members(), (self.mover, self.other), ((*mover, 35.0), (*other, 39.0)), strict=True)
        for member, vehicle, place in places:
            vehicle.start_enu_m = vehicle.goal_enu_m = np.array(place)
            vehicle.armed = True
            vehicle.mode = FlightMode.GUIDED
            give_task(roster, member, Task.RETURNING)
        self.other_member = roster.members()[1]
        self.roster = roster
        self.watch = WayWatch(roster, clock, Journal(clock))

    def take_over(self) -> None:
        self.other.mode, self.other.taken_over, self.other.has_pilot = (
            FlightMode.HOLD,
            "its mode changed to BRAKE",
            True,
        )
        self.roster.assign(self.other_member, Task.HELD)

    def lose(self) -> None:
        self.roster.assign(self.other_member, Task.LOST)

    def fail(self) -> None:
        self.other.mode, self.other.failsafe = FlightMode.RETURN, "battery critical"

    def hover_in_failsafe(self) -> None:
        self.other.mode, self.other.failsafe = FlightMode.HOLD, "battery critical"

    async def fly_home(self) -> None:
        await self.control.transfer({1: HOME}, RETURNING, returning=True)

    def stopped(self) -> list[int]:
        """Return the ids of the vehicles whose ways are withdrawn now; they are not told to stop."""
        return [member.vehicle_id for member in self.watch.look(self.control)]

    def beside_m(self) -> float:
        return float(np.linalg.norm((self.mover.position_enu_m() - self.other.position_enu_m())[:2]))


@pytest.mark.parametrize("happening", [Passing.take_over, Passing.hover_in_failsafe])
async def test_a_vehicle_flies_around_one_that_hovers_and_is_left_alone(happening: Callable[[Passing], None]) -> None:
    passing = Passing((0.0, 30.0), (0.2, 20.0))
    happening(passing)
    flying, nearest_m = asyncio.create_task(passing.fly_home()), passing.beside_m()
    while not flying.done():
        nearest_m = min(nearest_m, passing.beside_m())
        await asyncio.sleep(0.05)
    assert passing.mover.position_enu_m() == pytest.approx(HOME, abs=0.5)
    assert nearest_m >= SEPARATION_M + (1.0 if happening is Passing.take_over else 0.0)


async def test_where_one_side_is_barred_it_takes_the_other_and_where_both_are_it_waits() -> None:
    for narrow_on, is_home in (((-2.0, 99.0), True), ((-2.0, 2.5), False)):
        passing = Passing((0.0, 30.0), (-0.2, 20.0))
        passing.take_over()
        west_m, east_m = narrow_on
        narrow = ((west_m, -9.0), (east_m, -9.0), (east_m, 60.0), (west_m, 60.0))
        passing.bounds.set(replace(LIMITS, fence_enu_m=narrow))
        await passing.fly_home()
        assert np.allclose(passing.mover.position_enu_m(), HOME, atol=0.5) == is_home
        assert passing.beside_m() >= SEPARATION_M + 1.0


async def test_a_vehicle_that_cannot_pass_waits_where_the_other_may_drift_and_land() -> None:
    passing = Passing((0.0, 30.0), (0.2, 0.5))
    passing.take_over()
    await passing.fly_home()
    assert SEPARATION_M + 1.0 <= passing.beside_m() < SEPARATION_M + 2.0


async def test_a_vehicle_below_one_whose_pilot_takes_over_moves_out_of_its_column() -> None:
    passing = Passing((0.0, 20.7), (0.0, 20.0))
    passing.take_over()
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(5.0)
    assert passing.beside_m() >= SEPARATION_M + 1.0
    await flying


@pytest.mark.parametrize("north_m", [20.7, 20.0, 19.4, 30.0])
async def test_a_vehicle_below_a_lost_one_or_beyond_it_flies_home(north_m: float) -> None:
    passing = Passing((0.1, north_m), (0.0, 20.0))
    passing.other_member.home_enu_m = np.array([40.0, 0.0, 0.0])
    passing.lose()
    await passing.fly_home()
    assert passing.mover.position_enu_m() == pytest.approx(HOME, abs=0.5)


@pytest.mark.parametrize("seed", range(12))
async def test_vehicles_stacked_with_a_lost_one_fly_home(seed: int) -> None:
    rng, clock = np.random.default_rng(seed), LoopClock()
    fleet = FakeFleet(clock, 4, None)
    roster = Roster(fleet, clock)
    roster.refresh()
    roster.frame = LocalFrame(ORIGIN)
    settings = FlightSettings()
    bounds = FlightBounds(settings.arrival_radius_m, LIMITS)
    control = FlightControl(roster, clock, Journal(clock), settings, Deadlines(), bounds=bounds)
    lost, goals_enu_m = int(rng.integers(1, 5)), {}
    for row, member in enumerate(roster.members()):
        vehicle, layer_m = fleet.members[member.vehicle_id], 35.0 + 4.0 * row
        vehicle.start_enu_m = vehicle.goal_enu_m = np.array([*rng.normal((20.0, 20.0), 1.2), layer_m])
        vehicle.armed, vehicle.mode = True, FlightMode.GUIDED
        vehicle.horizontal_accuracy_m, vehicle.vertical_accuracy_m = 0.02, 0.03
        member.home_enu_m = np.array([4.0 * row - 40.0, 0.0, 0.0])
        give_task(roster, member, Task.RETURNING)
        if member.vehicle_id == lost:
            roster.assign(member, Task.LOST)
        else:
            goals_enu_m[member.vehicle_id] = np.array([*member.home_enu_m[:2], layer_m])
    assert await control.transfer(goals_enu_m, RETURNING, returning=True) == []


@pytest.mark.parametrize(
    ("name", "value"),
    [("has_pilot", True), ("altitude_doubt_m", 3.0), ("is_inaccurate", True)],
)
async def test_a_way_that_was_granted_is_withdrawn_when_another_vehicle_needs_more_room(
    name: str, value: float
) -> None:
    passing = Passing((0.0, 60.0), (0.0, 20.0))
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    assert passing.stopped() == []
    if name == "has_pilot":
        passing.take_over()
    else:
        passing.other.vertical_accuracy_m = 2.0
        setattr(passing.roster.members()[1], name, value)
    assert passing.stopped() == [1]
    assert passing.stopped() == [], "not within a second again"
    await asyncio.sleep(1.1)
    assert passing.stopped() == [1], "it flew on"
    flying.cancel()


@pytest.mark.parametrize("happening", [Passing.lose, Passing.fail])
@pytest.mark.parametrize(
    ("other", "home"),
    [((0.0, 20.0), (40.0, 0.0)), ((40.0, 20.0), (0.0, 10.0))],
    ids=["below or above it", "its launch point"],
)
async def test_a_way_is_withdrawn_where_another_vehicle_comes_down_by_itself(
    happening: Callable[[Passing], None], other: tuple[float, float], home: tuple[float, float]
) -> None:
    passing = Passing((0.0, 60.0), other)
    passing.other_member.home_enu_m = np.array([*home, 0.0])
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    assert passing.stopped() == []
    happening(passing)
    assert passing.stopped() == [1]
    flying.cancel()


async def test_ways_beside_all_that_another_vehicle_may_fly_by_itself_are_kept() -> None:
    passing = Passing((0.0, 60.0), (40.0, 20.0))
    passing.other_member.home_enu_m = np.array([40.0, 0.0, 0.0])
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    passing.lose()
    assert passing.stopped() == []
    await flying
    assert passing.mover.position_enu_m() == pytest.approx(HOME, abs=0.5)


async def test_a_vehicle_that_is_found_to_be_at_another_height_stops_before_it_passes_others() -> None:
    passing = Passing((0.0, 60.0), (0.0, 20.0))
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    passing.roster.members()[0].altitude_doubt_m = 3.0
    assert passing.stopped() == [1]
    flying.cancel()


async def test_a_vehicle_flies_on_away_from_one_with_a_pilot() -> None:
    passing = Passing((0.0, 19.0), (0.0, 20.0))
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    passing.take_over()
    assert passing.stopped() == []
    await flying
    assert passing.mover.position_enu_m() == pytest.approx(HOME, abs=0.5)
