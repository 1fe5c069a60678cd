"""The MAVLink driver above its sockets, joined to vehicles in memory."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import cast

from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.settings import CameraPlan
from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.service import MavlinkFleet
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.vehicle.cameras.exposure import CaptureTools
from aos_gcs.clock import LoopClock
from aos_gcs.ports import Clock, DriverContext, Notice, Vehicle
from tests.fakes.mavlink_vehicle import FakeVehicle

LATENCY_S = 0.05
TELEMETRY_PERIOD_S = 0.2


@dataclass
class Network:
    """An endpoint that hands packets over to fake vehicles, one address each."""

    vehicles: dict[PeerAddress, FakeVehicle]
    clock: Clock
    notices: list[Notice] = field(default_factory=list)
    fleet: MavlinkFleet | None = None
    is_healthy: bool = True
    silent: set[int] = field(default_factory=set)
    """System ids that send no telemetry by themselves."""

    def send(self, data: bytes, peer: PeerAddress) -> None:
        answers = self.vehicles[peer].hear(data)
        if answers:
            asyncio.get_running_loop().call_later(LATENCY_S, self.deliver, answers, peer)

    def deliver(self, data: bytes, peer: PeerAddress) -> None:
        assert self.fleet is not None
        self.fleet.receive(data, peer)

    def vehicle(self, system_id: int = 1) -> Vehicle:
        assert self.fleet is not None
        return self.fleet.vehicles()[system_id]

    async def talk(self) -> None:
        """Let all vehicles report for ever."""
        while True:
            for peer, vehicle in self.vehicles.items():
                if vehicle.system_id not in self.silent:
                    self.deliver(vehicle.telemetry() + vehicle.camera_heartbeat(), peer)
            await self.clock.sleep(TELEMETRY_PERIOD_S)


@asynccontextmanager
async def open_network(
    *vehicles: FakeVehicle, fetcher: object = None, cameras: CameraPlan | None = None
) -> AsyncIterator[Network]:
    """Join vehicles with a running driver; every vehicle has been heard when this yields."""
    clock = LoopClock()
    peers = {PeerAddress(0, f"10.0.0.{number}", 5000): vehicle for number, vehicle in enumerate(vehicles, 1)}
    network = Network(peers, clock)
    context = DriverContext(clock, lambda: network.is_healthy, network.notices.append)
    cameras = cameras or CameraPlan()
    receivers: list[asyncio.Task[None]] = []
    tools = CaptureTools(
        clock,
        cast("ImageFetcher", fetcher),
        cameras,
        network.notices.append,
        lambda work: receivers.append(asyncio.ensure_future(work)),
    )
    network.fleet = MavlinkFleet(MavlinkSession(254, 5.0, cameras=cameras), context, tools, None)
    network.fleet.add_endpoint(0, network, None)
    tasks = [asyncio.create_task(network.talk()), asyncio.create_task(network.fleet.run())]
    try:
        await asyncio.sleep(0)
        await clock.sleep(0.01)
        yield network
    finally:
        for task in (*tasks, *receivers):
            task.cancel()
        await asyncio.gather(*tasks, *receivers, return_exceptions=True)
