"""Vehicles that return past one that its pilot flies, who may land it at any time, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import FlightMode
from tests.fakes.fleet import ORIGIN, FakeFleet
from tests.fakes.roster import give_task

pytestmark = pytest.mark.looptime

SEPARATION_M = 1.5
HOME = np.array([0.0, 0.0, 35.0])
RETURNING = frozenset({Task.RETURNING})


class Passing:
    """Vehicle 1 returns in its layer; vehicle 2 is above its path, with a pilot from some time on."""

    def __init__(self, mover: tuple[float, float], other: tuple[float, float]) -> None:
        clock = LoopClock()
        self.fleet = FakeFleet(clock, 2, None)
        roster = Roster(self.fleet, clock)
        roster.refresh()
        roster.frame = LocalFrame(ORIGIN)
        self.control = FlightControl(roster, clock, Journal(clock), FlightSettings(), Deadlines(transfer_s=20.0))
        self.control.limits = SafetyLimits(
            fence_enu_m=((-99.0, -99.0), (99.0, -99.0), (99.0, 99.0), (-99.0, 99.0)),
            floor_m=20.0,
            ceiling_m=60.0,
            separation_m=SEPARATION_M,
        )
        self.mover, self.other = self.fleet.members[1], self.fleet.members[2]
        places = zip(roster.members(), (self.mover, self.other), ((*mover, 35.0), (*other, 39.0)), strict=True)
        for member, vehicle, place in places:
            vehicle.start_enu_m = vehicle.goal_enu_m = np.array(place)
            vehicle.armed = True
            vehicle.mode = FlightMode.GUIDED
            give_task(roster, member, Task.RETURNING)
        self.other_member = roster.members()[1]
        self.roster = roster

    def take_over(self) -> None:
        self.other.mode, self.other.taken_over, self.other.has_pilot = (
            FlightMode.HOLD,
            "its mode changed to BRAKE",
            True,
        )
        self.roster.assign(self.other_member, Task.HELD)

    async def fly_home(self) -> None:
        await self.control.transfer({1: HOME}, RETURNING, returning=True)

    def beside_m(self) -> float:
        return float(np.linalg.norm((self.mover.position_enu_m() - self.other.position_enu_m())[:2]))


async def test_a_vehicle_that_cannot_pass_waits_where_the_other_may_drift_and_land() -> None:
    passing = Passing((0.0, 30.0), (0.2, 20.0))
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


async def test_a_path_below_a_vehicle_is_vetted_anew_when_its_pilot_takes_over() -> None:
    passing = Passing((0.0, 40.0), (0.0, 5.0))
    flying = asyncio.create_task(passing.fly_home())
    await asyncio.sleep(1.0)
    passing.take_over()
    await flying
    assert passing.mover.position_enu_m()[1] >= 5.0 + SEPARATION_M, "it does not pass below"
