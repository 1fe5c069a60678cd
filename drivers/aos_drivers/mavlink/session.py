"""The MAVLink session with a swarm, without I/O: bytes and times in, events and packets out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.settings import CameraPlan
from aos_drivers.links.address import PeerAddress
from aos_drivers.links.boot_time import BOOT_TIMED_IDS, boot_ms_of
from aos_drivers.links.former import FormerOwner
from aos_drivers.links.framing import without_signature
from aos_drivers.links.heartbeat import HEARTBEAT_PERIOD_S, OUR_COMPONENT_ID, is_autopilot_heartbeat, our_heartbeat
from aos_drivers.links.identity import board_uid
from aos_drivers.mavlink.peers import Outgoing, PeerTable
from aos_drivers.mavlink.signing.signer import LinkSigner, SignatureCheck
from aos_drivers.vehicle.autopilots.base import Target, command_long, version_request
from aos_drivers.vehicle.failures import ReportFailures
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.status_text import notice_severity
from aos_gcs.ports import Notice, Severity

_REFUSALS = {
    SignatureCheck.UNSIGNED: "not signed; set the key on the vehicle, or append unsigned=accept to the link",
    SignatureCheck.WRONG_KEY: "signed with another key; set the same key on both sides",
    SignatureCheck.FAR_AHEAD: "signature time decades ahead; correct the vehicle's clock and set its key again",
    SignatureCheck.REPLAYED: "signature time too old; a vehicle whose clock is slow is being sent the time",
}


PacketReceived = tuple[bytes, int | None]
"""A valid packet that arrived, and the vehicle it belongs to: None for those of other ground stations and strangers."""


@dataclass(frozen=True, slots=True)
class VehicleFound:
    """The first heartbeat of a vehicle."""

    record: VehicleRecord


Event = PacketReceived | VehicleFound | Notice


class MavlinkSession:
    """Vehicles heard at the peers: their messages, and the requests to them."""

    def __init__(
        self,
        system_id: int,
        position_hz: float,
        signers: Mapping[int, LinkSigner] = MappingProxyType({}),
        cameras: CameraPlan | None = None,
        former: Mapping[int, FormerOwner] = MappingProxyType({}),
    ) -> None:
        """Send as ``system_id``, request positions at ``position_hz``, sign on the links in ``signers``.

        The messages that the vehicles' ``cameras`` need are requested, too. ``former`` are the vehicles of a flight
        that is taken up, by system id.
        """
        self._former = dict(former)
        self._cameras = cameras or CameraPlan()
        self._system_id = system_id
        self._position_hz = position_hz
        self._reported_refusals: set[tuple[int, int, SignatureCheck]] = set()
        self._peers = PeerTable(system_id, signers, lambda: {record.route.address for record in self.records.values()})
        self._failures = ReportFailures()
        """What was lost of senders that are no vehicle."""
        self._events: list[Event] = []
        self._heartbeat_due_s = -math.inf
        self._has_warned_of_own_id = False
        self.records: dict[int, VehicleRecord] = {}
        """Vehicles by system id, at most 254."""
        self._handlers: dict[int, Callable[[VehicleRecord, mavlink.MAVLink_message, PeerAddress, float], None]] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._on_heartbeat,
            mavlink.MAVLINK_MSG_ID_STATUSTEXT: self._on_status_text,
            mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: self._on_version,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
        }

    # --- in ---------------------------------------------------------------------------------------------------------

    def add_peer(self, peer: PeerAddress) -> None:
        """Send to ``peer`` before it has been heard."""
        self._peers.pin(peer)

    def feed(self, data: bytes, peer: PeerAddress, now_s: float) -> list[Event]:
        """Process bytes from ``peer`` as ``take`` does, and return what has happened."""
        self.take(data, peer, now_s)
        return self.take_events()

    def take(self, data: bytes, peer: PeerAddress, now_s: float) -> None:
        """Process bytes from ``peer``; what is not MAVLink is dropped and counted."""
        for message, refusal, is_signed in self._peers.receive(data, peer, now_s):
            try:
                if refusal is None:
                    self._on_packet(message, peer, now_s, is_signed)
                else:
                    self._report_refusal(message.get_srcSystem(), peer, refusal)
            except Exception as error:  # a defect at one packet, which must not end its link for all vehicles
                self._failures_of(message.get_srcSystem()).note(message.get_type(), error)

    def poll(self, now_s: float) -> list[Event]:
        """Do work that is due without a received packet. Call it several times a second."""
        for record in self.records.values():
            try:
                self._poll_vehicle(record, now_s)
            except Exception as error:  # a defect at one vehicle, which must not end the heartbeats to all
                record.failures.note("requests", error)
            self._events += record.notices(now_s)
        if (text := self._failures.text(now_s)) is not None:
            self._events.append(Notice(Severity.CRITICAL, text))
        for system_id, former in self._former.items():
            for peer in former.identity.questions(now_s):
                self._peers.send(version_request(Target(system_id, mavlink.MAV_COMP_ID_AUTOPILOT1)), peer)
        ownerships = [each.ownership for each in self.records.values()]
        ownerships += [each.ownership for each in self._former.values()]
        self._peers.intake.protected = frozenset().union(*(each.owners for each in ownerships if each.is_claimed))
        return self.take_events()

    # --- out --------------------------------------------------------------------------------------------------------

    def is_heartbeat_due(self, now_s: float) -> bool:
        """Whether the next heartbeat should go out. Late ticks policy: missed ones are skipped."""
        return now_s >= self._heartbeat_due_s

    def send_heartbeat(self, now_s: float) -> None:
        """Queue our heartbeat, once for each peer that carries a vehicle or that a link calls out to.

        An address that may be a new one of a vehicle in flight hears it before that is proven: failsafes do not wait.
        """
        next_s = self._heartbeat_due_s + HEARTBEAT_PERIOD_S
        self._heartbeat_due_s = next_s if next_s > now_s else now_s + HEARTBEAT_PERIOD_S
        claimed = [record.identity for record in self.records.values() if record.ownership.is_claimed]
        unproven = [peer for identity in claimed for peer in identity.living(now_s)]
        for peer in dict.fromkeys([*self._peers.called(), *unproven]):
            self._peers.send(our_heartbeat(), peer)

    def send(self, system_id: int, component_id: int, message: mavlink.MAVLink_message) -> None:
        """Queue a message for one component, at the one address that its route has chosen and at no other."""
        peer = self.records[system_id].address_of(component_id)
        if peer is not None:
            self._peers.send(message, peer)

    @property
    def has_outgoing(self) -> bool:
        """Whether there are packets to send."""
        return bool(self._peers.outgoing)

    def take_outgoing(self) -> list[Outgoing]:
        """Return and forget the packets to send."""
        return self._peers.take_outgoing()

    def take_events(self) -> list[Event]:
        """Return and forget what has happened: all calls of ``take`` until then are one reading of the links."""
        events, self._events = self._events, []
        return events

    # --- packets ----------------------------------------------------------------------------------------------------

    def _report_refusal(self, system_id: int, peer: PeerAddress, check: SignatureCheck) -> None:
        """Report each kind once per link and system id, but no repeated packets of a known vehicle."""
        key = (peer.link, system_id, check)
        if key not in self._reported_refusals and not (check is SignatureCheck.REPLAYED and system_id in self.records):
            self._reported_refusals.add(key)
            text = f"packets of system id {system_id} at {peer} are refused: {_REFUSALS[check]}"
            self._events.append(Notice(Severity.WARNING, text))

    def _on_unknown(self, message: mavlink.MAVLink_unknown, peer: PeerAddress) -> None:
        record = self.records.get(message.get_srcSystem())
        if record is not None:
            record.count_unknown(message.get_srcComponent(), message.get_seq(), peer)
        self._events.append((message.get_msgbuf(), None))

    def _on_packet(self, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float, is_signed: bool) -> None:
        if isinstance(message, mavlink.MAVLink_unknown):
            self._on_unknown(message, peer)
            return
        system_id = message.get_srcSystem()
        record = self.records.get(system_id)
        if record is None:
            record = self._find_vehicle(message, peer, now_s, is_signed)
        if record is not None:
            component_id = message.get_srcComponent()
            if not record.admits(component_id, peer, now_s, is_signed=is_signed):
                self._on_stranger(record, message, peer, now_s, is_signed)
                return
            if record.delay.is_boot_clock:
                record.watch_delay(message, now_s)
            is_moved = record.hear(component_id, message.get_seq(), peer, now_s, is_signed=is_signed)
            if record.identity.has_several_addresses and self._is_duplicate(record, message, peer, now_s):
                return
            self._events.append((message.get_msgbuf(), system_id))
            if is_moved and component_id == record.target.component_id:
                record.streams.restart()  # rates are a matter of each of the vehicle's links
                self._events.append(Notice(Severity.INFO, f"is now reached at {peer}", system_id))
            self._on_vehicle_packet(record, message, component_id, peer, now_s)
            return
        self._events.append((message.get_msgbuf(), None))
        if system_id == self._system_id and not self._has_warned_of_own_id:
            self._has_warned_of_own_id = True
            text = f"another ground station uses our system id {system_id}: change one of them"
            self._events.append(Notice(Severity.WARNING, text))

    def _on_stranger(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float, is_signed: bool
    ) -> None:
        """Ignore a packet with the id of an armed vehicle, but for what may prove that it comes from that vehicle."""
        self._events.append((message.get_msgbuf(), None))
        notice = record.take_stranger(message, peer, now_s, is_signed=is_signed)
        if notice is not None:
            self._events.append(notice)

    def _is_duplicate(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float
    ) -> bool:
        first = record.duplicates.first_sender(without_signature(message), peer, now_s)
        if first is None:
            return False
        if message.get_srcComponent() == record.target.component_id:
            self._peers.note_vehicle(peer)
            if message.get_msgId() in BOOT_TIMED_IDS:
                record.identity.hear_twice(peer, first)
        return True

    def _find_vehicle(
        self, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float, is_signed: bool
    ) -> VehicleRecord | None:
        system_id = message.get_srcSystem()
        former = self._former.get(system_id)
        if former is not None and not former.admits(peer, now_s, is_signed=is_signed):
            notice = former.take_stranger(message, peer, now_s, is_signed=is_signed)
            if notice is not None:
                self._events.append(notice)
            return None
        if system_id in (0, self._system_id) or not is_autopilot_heartbeat(message):
            return None
        target = Target(system_id, message.get_srcComponent())
        record = self.records[system_id] = VehicleRecord(
            target, message, self._position_hz, self._cameras.of(system_id), self._former.pop(system_id, None)
        )
        self._events.append(VehicleFound(record))
        text = f"heard at {peer}, autopilot {record.autopilot.name}"
        self._events.append(Notice(Severity.INFO, text, system_id))
        return record

    def _on_vehicle_packet(
        self,
        record: VehicleRecord,
        message: mavlink.MAVLink_message,
        component_id: int,
        peer: PeerAddress,
        now_s: float,
    ) -> None:
        message_id = message.get_msgId()
        is_autopilot = component_id == record.target.component_id
        if is_autopilot:
            self._peers.note_vehicle(peer)
            if message_id in BOOT_TIMED_IDS and record.identity.hear_boot_time(peer, boot_ms_of(message), now_s):
                record.restart()
                self._events.append(Notice(Severity.WARNING, "has restarted", record.vehicle_id))
            record.take_telemetry(message, message_id, now_s)
            record.streams.on_message(message_id)
            for exchange in record.exchanges:
                exchange.on_message(message)
        record.requests.on_message(component_id, message_id)
        record.take_payload(message, message_id, component_id, now_s)
        if message_id == mavlink.MAVLINK_MSG_ID_COMMAND_ACK:
            self._on_ack(record, message, now_s)
        elif is_autopilot and message_id in self._handlers:
            self._handlers[message_id](record, message, peer, now_s)

    def _on_heartbeat(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float
    ) -> None:
        if not is_autopilot_heartbeat(message):
            return
        record.watch_ownership(message, peer, now_s)
        record.take_heartbeat(message, now_s)

    def _on_status_text(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, _peer: PeerAddress, now_s: float
    ) -> None:
        for severity, text in record.texts.feed(message, now_s):
            self._take_text(record, severity, text, now_s)

    def _on_version(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float
    ) -> None:
        record.identity.hear_uid(peer, board_uid(message), now_s)
        self._watch_identity(record, now_s)

    def _on_timesync(
        self, record: VehicleRecord, message: mavlink.MAVLink_message, _peer: PeerAddress, now_s: float
    ) -> None:
        record.take_timesync(message, now_s)

    def _on_ack(self, record: VehicleRecord, ack: mavlink.MAVLink_command_ack_message, now_s: float) -> None:
        # 0 means "not given", as MAVLink 1 has no target in its acknowledgements.
        source = (ack.get_srcSystem(), ack.get_srcComponent())
        if ack.target_system not in (0, self._system_id):
            if source[1] == record.target.component_id:
                record.control.hear_answer_to_another(ack)
            return
        if ack.target_component not in (0, OUR_COMPONENT_ID):
            return
        for transaction in record.transactions:
            transaction.on_ack(ack, source, now_s)
        if ack.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL and source[1] == record.target.component_id:
            record.streams.on_ack()
            self._ask(record, now_s)

    def _take_text(self, record: VehicleRecord, severity: int, text: str, now_s: float) -> None:
        text = text.strip()  # PX4 marks texts that it also sends as events with a tab
        if severity >= mavlink.MAV_SEVERITY_DEBUG or not text:
            return
        if severity <= mavlink.MAV_SEVERITY_WARNING:
            record.take_warning(text, now_s)
        self._events.append(Notice(notice_severity(severity, text), text, record.vehicle_id))

    # --- vehicles ---------------------------------------------------------------------------------------------------

    def _failures_of(self, system_id: int) -> ReportFailures:
        record = self.records.get(system_id)
        return self._failures if record is None else record.failures

    def _poll_vehicle(self, record: VehicleRecord, now_s: float) -> None:
        for severity, text in record.texts.poll(now_s):
            self._take_text(record, severity, text, now_s)
        if record.identity.has_several_addresses:
            self._watch_identity(record, now_s)
        self._ask(record, now_s)

    def _watch_identity(self, record: VehicleRecord, now_s: float) -> None:
        is_ambiguous = record.is_ambiguous(now_s)
        if is_ambiguous and not record.was_ambiguous:
            text = (
                "two vehicles use this system id: neither is commanded; "
                "change the id of one of them (MAV_SYSID, SYSID_THISMAV or MAV_SYS_ID)"
            )
            self._events.append(Notice(Severity.CRITICAL, text, record.vehicle_id))
        elif record.was_ambiguous and not is_ambiguous:
            self._events.append(Notice(Severity.INFO, "its system id is unique again", record.vehicle_id))
        record.was_ambiguous = is_ambiguous

    def _ask(self, record: VehicleRecord, now_s: float) -> None:
        target = record.target
        for component_id, command, params in record.due_requests(now_s):
            self.send(
                target.system_id, component_id, command_long(Target(target.system_id, component_id), command, *params)
            )
        sent_ns = record.clock.poll(now_s)
        if sent_ns is not None:
            self.send(target.system_id, target.component_id, mavlink.MAVLink_timesync_message(0, sent_ns))
        for peer in record.identity.questions(now_s):
            self._peers.send(version_request(target), peer)
