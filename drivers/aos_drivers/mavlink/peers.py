"""Addresses of a session: received bytes are parsed and verified, packets to send are packed and signed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.links.heartbeat import OUR_COMPONENT_ID
from aos_drivers.links.intake import Intake, PeerIntake
from aos_drivers.mavlink.signing.signer import LinkSigner, SignatureCheck

_MAX_PEERS = 512
_FORGOTTEN_S = 60.0
_GOOD = SignatureCheck.GOOD


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A packet to send."""

    packet: bytes
    peer: PeerAddress


Received = tuple[mavlink.MAVLink_message, SignatureCheck | None, bool]
"""A valid packet, the reason to refuse it (None if it may be used), and whether it has a good signature."""


class _Peer:
    __slots__ = ("budget", "carries_vehicle", "encoder", "heard_at_s", "is_late", "is_pinned", "parser")

    def __init__(self, system_id: int) -> None:
        self.parser = FrameParser()
        self.budget = PeerIntake()
        self.encoder = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=OUR_COMPONENT_ID)
        self.heard_at_s = -math.inf
        self.is_pinned = False
        """Whether a link that calls out leads to it."""
        self.carries_vehicle = False
        self.is_late = False
        """Whether it signs with our key but an old time, which it can only learn from our heartbeats."""


class PeerTable:
    """Peers of a session, each with its own parser and sequence numbers.

    At most 512 peers are kept: a further one takes the place of the longest silent that carries no vehicle, or that has
    been silent for a minute and at which no vehicle is spoken to; else it is ignored.
    """

    def __init__(
        self, system_id: int, signers: Mapping[int, LinkSigner], in_use: Callable[[], Set[PeerAddress | None]]
    ) -> None:
        """Speak as ``system_id``, sign on the links in ``signers``, never forget the addresses in ``in_use()``."""
        self._system_id = system_id
        self._signers = signers
        self._in_use = in_use
        self._peers: dict[PeerAddress, _Peer] = {}
        self.outgoing: list[Outgoing] = []
        """Packets to send."""
        self.intake = Intake()

    def __len__(self) -> int:
        return len(self._peers)

    def __contains__(self, peer: PeerAddress) -> bool:
        return peer in self._peers

    def pin(self, peer: PeerAddress) -> None:
        """Send to ``peer`` before it has been heard, and never forget it."""
        self._add(peer).is_pinned = True

    def note_vehicle(self, peer: PeerAddress) -> None:
        """Send heartbeats to ``peer``, where a vehicle has just been heard, from now on."""
        self._peers[peer].carries_vehicle = True

    def called(self) -> list[PeerAddress]:
        """Return the peers that should hear our heartbeats."""
        return [
            peer for peer, entry in self._peers.items() if entry.carries_vehicle or entry.is_pinned or entry.is_late
        ]

    def receive(self, data: bytes, peer: PeerAddress, now_s: float) -> list[Received]:
        """Return the valid packets that ``data`` completes."""
        entry = self._peers.get(peer)
        if not self.intake.admits(peer, entry.budget if entry is not None else None, now_s):
            return []
        entry = entry or self._make_room_for(peer, now_s)
        if entry is None:
            return []
        entry.heard_at_s = now_s
        parser = entry.parser
        dropped = parser.dropped_bytes
        messages = parser.feed(data)
        self.intake.spend(peer, entry.budget, len(data), parser.dropped_bytes - dropped)
        signer = self._signers.get(peer.link)
        if signer is None:
            return [(message, None, False) for message in messages]
        received: list[Received] = []
        for message in messages:
            check = signer.check(message)
            entry.is_late = check is SignatureCheck.REPLAYED
            if check is _GOOD:
                received.append((message, None, True))
            else:
                received.append((message, None if signer.accepts(check, message) else check, False))
        return received

    def send(self, message: mavlink.MAVLink_message, peer: PeerAddress) -> None:
        """Queue a message, unless the peer has been forgotten for newer ones."""
        entry = self._peers.get(peer)
        if entry is None:
            return
        if peer.link in self._signers:
            self._signers[peer.link].prepare(entry.encoder)
        packet = message.pack(entry.encoder)
        entry.encoder.seq = (entry.encoder.seq + 1) % 256
        self.outgoing.append(Outgoing(packet, peer))

    def take_outgoing(self) -> list[Outgoing]:
        """Return and forget the packets to send."""
        outgoing, self.outgoing = self.outgoing, []
        return outgoing

    def _add(self, peer: PeerAddress) -> _Peer:
        return self._peers.setdefault(peer, _Peer(self._system_id))

    def _make_room_for(self, peer: PeerAddress, now_s: float) -> _Peer | None:
        if len(self._peers) >= _MAX_PEERS:
            in_use = self._in_use()
            idle = [
                address
                for address, entry in self._peers.items()
                if not entry.is_pinned
                and address not in in_use
                and (not entry.carries_vehicle or now_s - entry.heard_at_s > _FORGOTTEN_S)
            ]
            if not idle:
                return None
            del self._peers[min(idle, key=lambda address: self._peers[address].heard_at_s)]
        return self._add(peer)
