"""A swarm that hovers, whose vehicles a test sends wherever it wants them; a fake fleet in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import numpy as np

from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

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
