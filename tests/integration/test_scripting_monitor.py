"""A script's vehicles are watched like those of a mission, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.journal import Journal
from aos_gcs.planning.settings import Deadlines
from aos_gcs.scripting import ScriptOptions, Swarm
from tests.fakes.fleet import FakeFleet

pytestmark = pytest.mark.looptime

AREA_ENU_M = ((-20.0, 0.0), (20.0, 0.0), (20.0, 60.0), (-20.0, 60.0))


@asynccontextmanager
async def in_the_air() -> AsyncIterator[tuple[Swarm, FakeFleet, LoopClock]]:
    clock = LoopClock()
    fleet = FakeFleet(clock, 3, None)
    options = ScriptOptions(vehicles=3, area_enu_m=AREA_ENU_M, deadlines=Deadlines(transfer_s=60.0))
    swarm = Swarm(fleet, clock, Journal(clock), options)
    watching = asyncio.create_task(swarm.watch())
    await swarm.get_ready()
    await swarm.take_off()
    yield swarm, fleet, clock
    await swarm.come_home()
    watching.cancel()
    with suppress(asyncio.CancelledError):
        await watching
    assert not any(vehicle.armed for vehicle in fleet.members.values())


async def test_a_low_battery_in_flight_brings_its_vehicle_home() -> None:
    async with in_the_air() as (swarm, fleet, clock):
        await swarm.fly_to({1: (-10.0, 40.0), 2: (0.0, 40.0), 3: (10.0, 40.0)})
        fleet.members[2].battery_fraction = 0.1
        await clock.sleep(1.0)
        with pytest.raises(MissionError, match="vehicle 2 did not reach its place: it is returning"):
            await swarm.fly_to({2: (0.0, 50.0)})
        await clock.sleep(60.0)
        assert not fleet.members[2].armed
        assert fleet.members[2].position_enu_m() == pytest.approx(fleet.members[2].home_enu_m, abs=0.6)
        assert fleet.members[1].armed


async def test_a_lost_link_is_seen_without_any_command(caplog: pytest.LogCaptureFixture) -> None:
    async with in_the_air() as (_, fleet, clock):
        fleet.members[3].silent_since_s = clock.now_s()
        await clock.sleep(8.0)
        assert any("Vehicle 3: link lost" in record.getMessage() for record in caplog.records)
        fleet.members[3].silent_since_s = None
