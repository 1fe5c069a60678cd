"""Vehicles that land: what is below them, also below the way to their stop; a fake fleet in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import numpy as np
import pytest

from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Member, Roster
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold, Land
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.looptime

SEPARATION_M = 1.5
SWARM = frozenset({Task.SWARM})
AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 90.0), (-12.0, 90.0))


class Paused:
    """A swarm that hovers, paused, whose vehicles a test sends wherever it wants them in their layers."""

    def __init__(self, flight: Flight) -> None:
        self.flight = flight
        context = flight.mission.sortie.context
        self.control: FlightControl = context.flight
        self.roster: Roster = context.roster

    def member(self, number: int) -> Member:
        return self.roster.select([number])[0]

    def vehicle(self, number: int) -> FakeVehicle:
        return self.flight.fleet.members[number]

    async def fly(self, number: int, east_m: float, north_m: float) -> None:
        place_enu_m = self.roster.layers.at(self.member(number), np.array([east_m, north_m, 0.0]))
        assert place_enu_m is not None
        assert not await self.control.transfer({number: place_enu_m}, SWARM)

    async def set_off(self, number: int, north_m: float) -> None:
        """Send a vehicle straight north or south, and do not wait for it."""
        place_enu_m = self.roster.layers.at(self.member(number), np.array([0.0, north_m, 0.0]))
        assert place_enu_m is not None
        await self.control.send(self.control.vet({number: place_enu_m}), tasks=SWARM)

    async def land(self, *numbers: int) -> list[str]:
        """Order vehicles, or all, to land, and return why it was refused."""
        results = await self.flight.commands.act(Action.LAND, numbers or None, operator="Ada")
        return [result.text for result in results if not result.accepted]


@asynccontextmanager
async def paused(n: int = 3) -> AsyncIterator[Paused]:
    flight = prepare(n, None, area_enu_m=AREA)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(3.0)
        yield Paused(flight)
        if flight.mission.phase not in {Phase.LAND, Phase.DONE}:
            await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_moving_vehicle_is_not_landed_onto_one_that_hovers_below_the_way_to_its_stop() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 70.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 88.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 53.0))
        assert await swarm.land(3) == [
            "vehicle 1 is or may come below it before it stops: hold it, then land it",
        ]
        assert Land() not in swarm.vehicle(3).commands
        await swarm.flight.commands.act(Action.HOLD, (3,))
        assert await swarm.land(3) == [], "it hovers beside vehicle 1"
        await swarm.flight.until(lambda: swarm.flight.task(3) is Task.LANDED)


async def test_a_moving_vehicle_lands_at_once_where_nobody_is_below_the_way_to_its_stop() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 70.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 60.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 25.0))
        assert await swarm.land(3) == []
        assert swarm.vehicle(3).commands[-1] == Land()


async def test_all_that_move_stop_before_they_land_and_move_apart_where_they_have_stopped() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 80.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(1, 20.0)
        await swarm.set_off(3, 80.0)
        vehicles = swarm.vehicle(1), swarm.vehicle(3)
        first, third = vehicles
        await swarm.flight.until(lambda: bool(first.position_enu_m()[1] - third.position_enu_m()[1] < 1.0))
        told = [len(vehicle.commands) for vehicle in vehicles]
        assert await swarm.land() == []
        await swarm.flight.until(lambda: all(swarm.flight.task(number) is Task.LANDED for number in (1, 2, 3)))
        assert all(isinstance(vehicle.commands[before], Hold) for vehicle, before in zip(vehicles, told, strict=True))
        places_enu_m = [vehicle.true_enu_m() for vehicle in vehicles]
        assert np.linalg.norm(places_enu_m[0] - places_enu_m[1]) > SEPARATION_M


async def test_the_way_to_the_stop_of_a_vehicle_that_lands_is_kept_free_below() -> None:
    """It comes down anywhere on that way, and ends at the place where it stops."""
    async with paused() as swarm:
        await swarm.fly(1, -8.0, 40.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 60.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 22.0))
        across = swarm.roster.layers.at(swarm.member(1), np.array([8.0, 40.0, 0.0]))
        assert across is not None
        (before,) = swarm.control.vet({1: across})
        assert before.reason == ""
        lander = swarm.member(3)
        lander.last_command = Land()  # handed to the link: it still flies on as before
        (record,) = swarm.control.vet({1: across})
        assert "vehicle 3" in record.reason
        await swarm.flight.commands.act(Action.HOLD, None)
