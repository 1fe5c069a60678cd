"""Routing between our sockets and MAVSDK: each packet to one vehicle, heartbeats only while the service is healthy."""

from __future__ import annotations

from collections.abc import Callable

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.links.heartbeat import OUR_COMPONENT_ID, our_heartbeat
from aos_drivers.links.intake import Intake, PeerIntake
from aos_drivers.links.opener import Endpoint
from aos_drivers.vehicle.autopilots.base import Target

ANY_COMPONENT: int = mavlink.MAV_COMP_ID_ALL
_MAX_PEERS = 512


class _Peer:
    def __init__(self, system_id: int) -> None:
        self.parser = FrameParser()
        self.budget = PeerIntake()
        self.encoder = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=OUR_COMPONENT_ID)
        self.is_called = False
        """Whether it hears our heartbeats: it carries a vehicle, or a link that calls out leads to it."""


class Wire:
    """Router between the links and MAVSDK's raw connection.

    MAVSDK's own UDP link sends every packet to every vehicle, and its heartbeat goes on when the service hangs. Here a
    packet goes to the address where its target was heard last, and MAVSDK's heartbeats are replaced by ours. At most
    512 addresses are kept; further ones are ignored.
    """

    def __init__(
        self,
        system_id: int,
        deliver: Callable[[bytes], None],
        note: Callable[[mavlink.MAVLink_message, PeerAddress, float], bool],
        record: Callable[[bytes], None],
        time_ago_s: Callable[[float], float],
    ) -> None:
        """``deliver`` passes a packet to MAVSDK, ``note`` sees it before and says whether it is passed on.

        ``note`` takes the clock time of its arrival, too. ``record`` records both directions. ``time_ago_s`` returns
        the clock time of some real seconds ago.
        """
        self._system_id = system_id
        self._deliver = deliver
        self._note = note
        self._record = record
        self._peers: dict[PeerAddress, _Peer] = {}
        self._endpoints: dict[int, Endpoint] = {}
        self._routes: dict[tuple[int, int], PeerAddress] = {}
        self._from_core = FrameParser()
        self._time_ago_s = time_ago_s
        self.intake = Intake()

    def add_endpoint(self, link: int, endpoint: Endpoint, peer: PeerAddress | None) -> None:
        """Use an open link; heartbeats go to ``peer`` before it has been heard."""
        self._endpoints[link] = endpoint
        if peer is not None:
            self._peers.setdefault(peer, _Peer(self._system_id)).is_called = True

    def receive(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        """Process bytes of a link that came ``waited_s`` ago, in real seconds; MAVSDK receives the valid packets."""
        entry, now_s = self._peers.get(peer), self._time_ago_s(waited_s)
        if not self.intake.admits(peer, entry.budget if entry is not None else None, now_s):
            return
        if entry is None:
            if len(self._peers) >= _MAX_PEERS:
                return
            entry = self._peers[peer] = _Peer(self._system_id)
        dropped = entry.parser.dropped_bytes
        messages = entry.parser.feed(data)
        self.intake.spend(peer, entry.budget, len(data), entry.parser.dropped_bytes - dropped)
        for message in messages:
            packet = bytes(message.get_msgbuf())
            self._record(packet)
            if self._note(message, peer, now_s):
                self._deliver(packet)

    def route(self, system_id: int, component_id: int, peer: PeerAddress) -> None:
        """Send packets for a component to this address from now on; ``ANY_COMPONENT`` means those not heard."""
        self._routes[system_id, component_id] = peer
        self.call(peer)

    def call(self, peer: PeerAddress) -> None:
        """Send heartbeats to this address, where a vehicle was heard, from now on."""
        self._peers[peer].is_called = True

    def host_of(self, system_id: int, component_id: int) -> str:
        """Return the host where a component was heard last; empty if it was never heard."""
        peer = self._routes.get((system_id, component_id))
        return peer.host if peer is not None else ""

    def send(self, packet: bytes) -> None:
        """Route a packet of MAVSDK. Its heartbeats, and packets without a known target, are dropped."""
        for message in self._from_core.feed(packet):
            system_id, component_id = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
            peer = self._routes.get((system_id, component_id)) or self._routes.get((system_id, ANY_COMPONENT))
            if peer is not None and not isinstance(message, mavlink.MAVLink_unknown):
                self._send_to(peer, message)

    def send_to(self, target: Target, message: mavlink.MAVLink_message) -> None:
        """Send a message without a target field to one component, bypassing MAVSDK."""
        peer = self._routes.get((target.system_id, target.component_id))
        if peer is not None:
            self._send_to(peer, message)

    def send_to_peer(self, peer: PeerAddress, message: mavlink.MAVLink_message) -> None:
        """Send a message to one address, whatever is routed there."""
        if peer in self._peers:
            self._send_to(peer, message)

    def send_heartbeat(self) -> None:
        """Send our heartbeat, once to each address that carries a vehicle or that a link calls out to."""
        for peer, entry in self._peers.items():
            if entry.is_called:
                self._send_to(peer, our_heartbeat())

    def _send_to(self, peer: PeerAddress, message: mavlink.MAVLink_message) -> None:
        """Pack anew: every address has its own sequence numbers, or vehicles would count the gaps as losses."""
        endpoint = self._endpoints.get(peer.link)
        if endpoint is None:
            return
        encoder = self._peers[peer].encoder
        packet = bytes(message.pack(encoder))
        encoder.seq = (encoder.seq + 1) % 256
        endpoint.send(packet, peer)
        self._record(packet)
