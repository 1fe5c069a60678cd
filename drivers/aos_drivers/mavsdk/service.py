"""The driver: links, MAVSDK and vehicles under one owner."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from types import MappingProxyType

import aiohttp
from mavsdk import Mavsdk
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.background import BackgroundTasks
from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.links.address import LinkAddress, PeerAddress, parse_link
from aos_drivers.links.former import former_owners
from aos_drivers.links.heartbeat import HEARTBEAT_PERIOD_S, is_autopilot_heartbeat
from aos_drivers.links.identity import board_uid
from aos_drivers.links.opener import LinkOpener
from aos_drivers.links.recorder import open_recorder
from aos_drivers.mavsdk.core import LoopDispatcher, open_core
from aos_drivers.mavsdk.vehicle import MavsdkVehicle, make_vehicle
from aos_drivers.mavsdk.wire import ANY_COMPONENT, Wire
from aos_drivers.options import DriverOptions
from aos_drivers.vehicle.autopilots.base import Target, version_request
from aos_drivers.vehicle.cameras.exposure import CaptureTools
from aos_drivers.vehicle.cameras.runner import report_receiver
from aos_drivers.vehicle.failures import ReportFailures
from aos_drivers.vehicle.record import VehicleRecord
from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import (
    DriverContext,
    Notice,
    Severity,
)

TICK_S = 0.1
"""Clock seconds between two checks for due work; a late one is skipped."""


class MavsdkFleet:
    """The vehicles heard on the links (``aos_gcs.ports.Fleet``)."""

    def __init__(self, core: Mavsdk, context: DriverContext, tools: CaptureTools, position_hz: float) -> None:
        self._core = core
        self._context = context
        self._tools = tools
        self._position_hz = position_hz
        self._former = former_owners(context.former, context.clock)
        """Vehicles of a flight that is taken up, which have not been heard yet, by system id."""
        self._failures = ReportFailures()
        """What was lost of senders that are no vehicle."""
        self._records: dict[int, VehicleRecord] = {}
        """Records by system id, including vehicles that MAVSDK has not found yet."""
        self._vehicles: dict[int, MavsdkVehicle] = {}
        self._ambiguous: set[int] = set()

    def vehicles(self) -> Mapping[int, MavsdkVehicle]:
        """Return all vehicles ever heard, by system id."""
        return MappingProxyType(self._vehicles)

    def take(self, wire: Wire, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float) -> bool:
        """Note a packet as ``note`` does; one at which that fails is counted, and kept from MAVSDK."""
        try:
            return self.note(wire, message, peer, now_s)
        except Exception as error:  # a defect at one packet, which must not end its link for all vehicles
            record = self._records.get(message.get_srcSystem())
            (self._failures if record is None else record.failures).note(message.get_type(), error)
            return False

    def note(self, wire: Wire, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float) -> bool:
        """Record what MAVSDK does not report: time and address of each packet, and system ids used twice.

        ``now_s`` is when it came. Returns whether MAVSDK may have the packet.
        """
        system_id = message.get_srcSystem()
        record = self._records.get(system_id)
        if record is None:
            former = self._former.get(system_id)
            if former is not None and not former.admits(peer, now_s):
                self._notify(former.take_stranger(message, peer, now_s))
                return False
            if system_id in (0, self._context.system_id) or not is_autopilot_heartbeat(message):
                return True
            target, camera = Target(system_id, message.get_srcComponent()), self._tools.cameras.of(system_id)
            former = self._former.pop(system_id, None)
            record = self._records[system_id] = VehicleRecord(target, message, self._position_hz, camera, former)
        component_id = message.get_srcComponent()
        if isinstance(message, mavlink.MAVLink_unknown):
            record.count_unknown(component_id, message.get_seq(), peer)
            return True
        if not record.admits(component_id, peer, now_s):
            self._notify(record.take_stranger(message, peer, now_s))
            return False
        record.watch_delay(message, now_s)
        record.hear(component_id, message.get_seq(), peer, now_s)
        wire.route(system_id, component_id, record.address_of(component_id) or peer)
        record.requests.on_message(component_id, message.get_msgId())
        record.take_payload(message, message.get_msgId(), component_id, now_s)
        if system_id in self._vehicles:
            self._vehicles[system_id].announce()
        if component_id == record.target.component_id:
            wire.route(system_id, ANY_COMPONENT, record.route.address or peer)
            wire.call(peer)
            self._note_autopilot(record, message, peer, now_s)
        return True

    def _note_autopilot(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float
    ) -> None:
        record.streams.on_message(message.get_msgId())
        for exchange in record.exchanges:
            exchange.on_message(message)
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_COMMAND_ACK:
            # MAVSDK keeps to itself what is addressed to others.
            if message.target_system not in (0, self._context.system_id):
                record.control.hear_answer_to_another(message)
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
            if record.identity.hear_boot_time(peer, message.time_boot_ms, now_s):
                record.restart()
                self._context.notify(Notice(Severity.WARNING, "has restarted", record.vehicle_id))
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            record.identity.hear_uid(peer, board_uid(message), now_s)
            record.telemetry.update(message, now_s)
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_TIMESYNC:
            record.take_timesync(message, now_s)
        elif is_autopilot_heartbeat(message):
            record.watch_ownership(message, peer, now_s)

    async def run(self, wire: Wire, dispatcher: LoopDispatcher) -> None:
        """Do due work until cancelled."""
        clock = self._context.clock
        heartbeat_due_s = -math.inf
        while True:
            now_s = clock.now_s()
            if len(self._vehicles) < len(self._records):
                self._find_vehicles(wire, dispatcher)
            for vehicle_id in self._vehicles:
                record = self._records[vehicle_id]
                try:
                    self._poll_vehicle(wire, vehicle_id, record, now_s)
                except Exception as error:  # a defect at one vehicle, which must not end the heartbeats to all
                    record.failures.note("requests", error)
                for notice in record.notices(now_s):
                    self._context.notify(notice)
            if (text := self._failures.text(now_s)) is not None:
                self._context.notify(Notice(Severity.CRITICAL, text))
            for system_id, former in self._former.items():
                for peer in former.identity.questions(now_s):
                    wire.send_to_peer(peer, version_request(Target(system_id, mavlink.MAV_COMP_ID_AUTOPILOT1)))
            ownerships = [each.ownership for each in self._records.values()]
            ownerships += [each.ownership for each in self._former.values()]
            wire.intake.protected = frozenset().union(*(each.owners for each in ownerships))
            if now_s >= heartbeat_due_s and self._context.is_healthy():
                wire.send_heartbeat()
                heartbeat_due_s = now_s + HEARTBEAT_PERIOD_S
            await clock.sleep(TICK_S)

    def _poll_vehicle(self, wire: Wire, vehicle_id: int, record: VehicleRecord, now_s: float) -> None:
        self._vehicles[vehicle_id].poll(now_s)
        self._watch_identity(vehicle_id, now_s)
        for peer in record.identity.questions(now_s):
            wire.send_to_peer(peer, version_request(record.target))
        if (sent_ns := record.clock.poll(now_s)) is not None:
            wire.send_to(record.target, mavlink.MAVLink_timesync_message(0, sent_ns))

    def _notify(self, notice: Notice | None) -> None:
        if notice is not None:
            self._context.notify(notice)

    def _find_vehicles(self, wire: Wire, dispatcher: LoopDispatcher) -> None:
        for system in self._core.get_systems():
            system_id = system.get_system_id()
            record = self._records.get(system_id)
            if record is not None and system_id not in self._vehicles:
                vehicle = make_vehicle(
                    system, record, context=self._context, tools=self._tools, wire=wire, dispatcher=dispatcher
                )
                self._vehicles[system_id] = vehicle
                host = wire.host_of(system_id, ANY_COMPONENT)
                text = f"heard at {host}, autopilot {record.autopilot.name}"
                self._context.notify(Notice(Severity.INFO, text, system_id))

    def _watch_identity(self, vehicle_id: int, now_s: float) -> None:
        is_ambiguous = self._records[vehicle_id].is_ambiguous(now_s)
        if is_ambiguous and vehicle_id not in self._ambiguous:
            self._ambiguous.add(vehicle_id)
            text = "two vehicles use this system id: neither is commanded; change the id of one of them"
            self._context.notify(Notice(Severity.CRITICAL, text, vehicle_id))
        elif not is_ambiguous:
            self._ambiguous.discard(vehicle_id)


@asynccontextmanager
async def open_mavsdk(links: Sequence[str], context: DriverContext) -> AsyncIterator[MavsdkFleet]:
    """Open the links and yield the fleet (``aos_gcs.ports.Driver``). Links and options are those of ``open_mavlink``.

    Raises:
        ConfigurationError: a link or option cannot be understood, or the log folder cannot be written.
        LinkError: a link cannot be opened.
    """
    options = DriverOptions.parse(context.options)
    addresses = [_unsigned(parse_link(text)) for text in links]
    if not addresses:
        raise ConfigurationError("the mavsdk driver needs at least one link, such as udpin://0.0.0.0:14550")
    async with AsyncExitStack() as stack:
        recorder = await open_recorder(stack, context)
        http = await stack.enter_async_context(aiohttp.ClientSession())
        fetcher = ImageFetcher(http, context.clock, options.image_limits, options.image_hosts, context.decoding)
        receivers = await stack.enter_async_context(BackgroundTasks(lambda error: report_receiver(context, error)))
        tools = CaptureTools(context.clock, fetcher, options.cameras, context.notify, receivers.start)
        core, feeder = await stack.enter_async_context(open_core(context.system_id))
        fleet = MavsdkFleet(core, context, tools, options.position_hz)
        dispatcher = LoopDispatcher()
        stack.callback(dispatcher.close)

        def record(packet: bytes) -> None:
            if recorder is not None:
                recorder.write(packet, context.clock.utc_s())

        wire = Wire(
            context.system_id,
            feeder.feed,
            lambda message, peer, now_s: fleet.take(wire, message, peer, now_s),
            record,
            lambda ago_s: context.clock.now_s() - ago_s * context.clock.speed,
        )
        core.subscribe_raw_bytes_to_be_sent(lambda packet: dispatcher.to_loop(wire.send)(packet, None))
        tasks = await stack.enter_async_context(BackgroundTasks(lambda error: _report_failure(context, error)))
        opener = LinkOpener(
            stack, tasks, context.clock, wire.receive, lambda text: context.notify(Notice(Severity.WARNING, text))
        )
        for number, address in enumerate(addresses):
            wire.add_endpoint(number, *await opener.open(number, address))
        tasks.start(fleet.run(wire, dispatcher))
        yield fleet


def _unsigned(address: LinkAddress) -> LinkAddress:
    if address.signing is not None:
        raise ConfigurationError(f"link {address.text!r}: the mavsdk driver cannot sign; use the driver mavlink for it")
    return address


def _report_failure(context: DriverContext, error: BaseException) -> None:
    text = f"the mavsdk driver has failed and no longer sends heartbeats: {error!r}; restart the service"
    context.notify(Notice(Severity.CRITICAL, text))
