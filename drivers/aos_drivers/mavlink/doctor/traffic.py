"""Senders heard on the links, counted without trusting any packet. No I/O; for ``aos-gcs doctor``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser, is_signed
from aos_drivers.links.identity import board_uid
from aos_drivers.links.loss import LossCounter
from aos_drivers.mavlink.signing.signer import LinkSigner, SignatureCheck

_MAX_PEERS = 512
_MAX_SENDERS = 2048


@dataclass(slots=True)
class Sender:
    """One component of one system at one address."""

    system_id: int
    component_id: int
    peer: PeerAddress
    heard_at_s: float = 0.0
    packets: int = 0
    mavlink1_packets: int = 0
    signed_packets: int = 0
    heartbeat: mavlink.MAVLink_heartbeat_message | None = None
    uid: bytes | None = None
    signature_checks: Counter[SignatureCheck] = field(default_factory=Counter)
    """Results of checking the signatures, where the link has a key."""
    message_counts: Counter[int] = field(default_factory=Counter)
    """Packets by message id since ``Traffic.start_rates``."""
    loss: LossCounter = field(default_factory=LossCounter)

    @property
    def is_autopilot(self) -> bool:
        """Whether its heartbeats are those of a vehicle's autopilot."""
        return self.heartbeat is not None and self.heartbeat.autopilot != mavlink.MAV_AUTOPILOT_INVALID

    @property
    def is_ground_station(self) -> bool:
        """Whether its heartbeats are those of a ground station."""
        return self.heartbeat is not None and self.heartbeat.type == mavlink.MAV_TYPE_GCS


class Traffic:
    """Count of what arrives, bounded to 512 addresses and 2048 senders; further ones are not counted."""

    def __init__(self, signers: Mapping[int, LinkSigner]) -> None:
        """Check signatures on the links in ``signers``, which must not be shared."""
        self._signers = signers
        self._parsers: dict[PeerAddress, FrameParser] = {}
        self._senders: dict[tuple[PeerAddress, int, int], Sender] = {}
        self._rates_from_s = 0.0
        self.bytes_by_link: Counter[int] = Counter()
        """Bytes received on each link, MAVLink or not."""

    @property
    def senders(self) -> list[Sender]:
        """All senders, by system, component and address."""
        return sorted(self._senders.values(), key=lambda entry: (entry.system_id, entry.component_id, entry.peer))

    def feed(self, data: bytes, peer: PeerAddress, now_s: float) -> None:
        """Take bytes that came from ``peer``."""
        self.bytes_by_link[peer.link] += len(data)
        if peer not in self._parsers and len(self._parsers) >= _MAX_PEERS:
            return
        for message in self._parsers.setdefault(peer, FrameParser()).feed(data):
            self._count(message, peer, now_s)

    def start_rates(self, now_s: float) -> None:
        """Count message rates from now on."""
        self._rates_from_s = now_s
        for sender in self._senders.values():
            sender.message_counts.clear()

    def rate_hz(self, system_id: int, message_id: int, now_s: float) -> float:
        """Return how often an autopilot has sent a message since ``start_rates``, at its best address."""
        counts = [
            sender.message_counts[message_id]
            for sender in self._senders.values()
            if sender.system_id == system_id and sender.is_autopilot
        ]
        return max(counts, default=0) / max(1e-9, now_s - self._rates_from_s)

    def _count(self, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float) -> None:
        system_id, component_id = message.get_srcSystem(), message.get_srcComponent()
        key = (peer, system_id, component_id)
        if key not in self._senders and len(self._senders) >= _MAX_SENDERS:
            return
        sender = self._senders.setdefault(key, Sender(system_id, component_id, peer))
        packet = bytes(message.get_msgbuf())
        sender.heard_at_s = now_s
        sender.packets += 1
        sender.mavlink1_packets += packet[0] == mavlink.PROTOCOL_MARKER_V1
        sender.signed_packets += is_signed(packet)
        sender.message_counts[message.get_msgId()] += 1
        sender.loss.count(message.get_seq())
        if peer.link in self._signers:
            sender.signature_checks[self._signers[peer.link].verify(packet, (system_id, component_id))] += 1
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            sender.heartbeat = message
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            uid = board_uid(message)
            sender.uid = uid if any(uid) else sender.uid
