"""The driver: links, session and vehicles under one owner."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from types import MappingProxyType

import aiohttp
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.background import BackgroundTasks
from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.links.address import PeerAddress, parse_link
from aos_drivers.links.former import former_owners
from aos_drivers.links.opener import Endpoint, LinkOpener
from aos_drivers.links.recorder import TlogRecorder, open_recorder
from aos_drivers.mavlink.component import ComponentSource
from aos_drivers.mavlink.session import Event, MavlinkSession, VehicleFound
from aos_drivers.mavlink.signing.keyring import Keyring
from aos_drivers.options import DriverOptions
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess
from aos_drivers.vehicle.cameras.runner import report_receiver
from aos_drivers.vehicle.mavlink_vehicle import MavlinkVehicle
from aos_drivers.vehicle.waiting import Changes
from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import (
    DriverContext,
    Notice,
    Severity,
    Vehicle,
)

TICK_S = 0.1
"""Clock seconds between two checks for due work; a late one is skipped."""


class MavlinkFleet:
    """The vehicles heard on the links (``aos_gcs.ports.Fleet``), and the traffic between them and the session."""

    def __init__(
        self, session: MavlinkSession, context: DriverContext, tools: CaptureTools, recorder: TlogRecorder | None
    ) -> None:
        self._session = session
        self._context = context
        self._tools = tools
        self._recorder = recorder
        self._endpoints: dict[int, Endpoint] = {}
        self._vehicles: dict[int, Vehicle] = {}
        self._changes: dict[int, Changes] = {}
        self._speed = context.clock.speed
        self._read_at_s: float | None = None
        """Clock time of the reading that is in progress."""

    def vehicles(self) -> Mapping[int, Vehicle]:
        """Return all vehicles ever heard, by system id."""
        return MappingProxyType(self._vehicles)

    def add_endpoint(self, link: int, endpoint: Endpoint, peer: PeerAddress | None) -> None:
        """Use an open link; heartbeats go to ``peer`` before it has been heard."""
        self._endpoints[link] = endpoint
        if peer is not None:
            self._session.add_peer(peer)

    def receive(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        """Process bytes of a link that came ``waited_s`` ago, in real seconds."""
        try:
            self.take(data, peer, waited_s)
        finally:
            self.settle()

    def take(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        """Process bytes of a link as ``receive`` does, as part of a reading that ``settle`` ends."""
        if self._read_at_s is None:
            self._read_at_s = self._context.clock.now_s()
        self._session.take(data, peer, self._read_at_s - waited_s * self._speed)

    def settle(self) -> None:
        """Record what was read, tell those who wait for it, and send the answers to it."""
        self._read_at_s = None
        self._handle(self._session.take_events())
        if self._session.has_outgoing:
            self._flush()

    async def run(self) -> None:
        """Do due work until cancelled."""
        clock = self._context.clock
        while True:
            now_s = clock.now_s()
            self._handle(self._session.poll(now_s))
            if self._session.is_heartbeat_due(now_s) and self._context.is_healthy():
                self._session.send_heartbeat(now_s)
            self._flush()
            await clock.sleep(TICK_S)

    def _send(self, system_id: int, component_id: int, message: mavlink.MAVLink_message) -> None:
        self._session.send(system_id, component_id, message)
        self._flush()

    def _handle(self, events: list[Event]) -> None:
        packets: list[bytes] = []
        heard_ids: dict[int | None, None] = {}
        for event in events:
            match event:
                case (packet, vehicle_id):
                    packets.append(packet)
                    heard_ids[vehicle_id] = None
                case VehicleFound(record):
                    changes = self._changes[record.vehicle_id] = Changes(self._context.clock)
                    access = VehicleAccess(record, self._send, changes, record.host_of)
                    make_source = partial(ComponentSource, access, self._tools)
                    vehicle = MavlinkVehicle(access, self._tools, make_source, self._context.system_id)
                    self._vehicles[record.vehicle_id] = vehicle
                case Notice():
                    self._context.notify(event)
        self._record(packets)
        for heard_id in heard_ids:
            if heard_id is not None:
                self._changes[heard_id].announce()

    def _flush(self) -> None:
        packets: list[bytes] = []
        for outgoing in self._session.take_outgoing():
            endpoint = self._endpoints.get(outgoing.peer.link)
            if endpoint is not None:
                endpoint.send(outgoing.packet, outgoing.peer)
                packets.append(outgoing.packet)
        self._record(packets)

    def _record(self, packets: Sequence[bytes]) -> None:
        if packets and self._recorder is not None:
            self._recorder.write_all(packets, self._context.clock.utc_s())


@asynccontextmanager
async def open_mavlink(links: Sequence[str], context: DriverContext) -> AsyncIterator[MavlinkFleet]:
    """Open the links and yield the fleet (``aos_gcs.ports.Driver``). Its options are those of ``DriverOptions``.

    Raises:
        ConfigurationError: a link or option cannot be understood, or the log folder or a key cannot be used.
        LinkError: a link cannot be opened.
    """
    options = DriverOptions.parse(context.options)
    addresses = [parse_link(text) for text in links]
    if not addresses:
        raise ConfigurationError("the mavlink driver needs at least one link, such as udpin://0.0.0.0:14550")
    async with AsyncExitStack() as stack:
        recorder = await open_recorder(stack, context)
        http = await stack.enter_async_context(aiohttp.ClientSession())
        fetcher = ImageFetcher(http, context.clock, options.image_limits, options.image_hosts, context.decoding)
        receivers = await stack.enter_async_context(BackgroundTasks(lambda error: report_receiver(context, error)))
        tools = CaptureTools(context.clock, fetcher, options.cameras, context.notify, receivers.start)
        keyring = await asyncio.to_thread(Keyring, addresses, context.clock)
        stack.push_async_callback(asyncio.to_thread, keyring.close)
        former = former_owners(context.former, context.clock, keyring.signers)
        session = MavlinkSession(context.system_id, options.position_hz, keyring.signers, options.cameras, former)
        fleet = MavlinkFleet(session, context, tools, recorder)
        tasks = await stack.enter_async_context(BackgroundTasks(lambda error: _report_failure(context, error)))
        opener = LinkOpener(
            stack,
            tasks,
            context.clock,
            fleet.take,
            lambda text: context.notify(Notice(Severity.WARNING, text)),
            settle=fleet.settle,
        )
        for number, address in enumerate(addresses):
            fleet.add_endpoint(number, *await opener.open(number, address))
        tasks.start(fleet.run())
        tasks.start(keyring.run())
        yield fleet


def _report_failure(context: DriverContext, error: BaseException) -> None:
    text = f"the mavlink driver has failed and no longer sends heartbeats: {error!r}; restart the service"
    context.notify(Notice(Severity.CRITICAL, text))
