"""A radio network in memory: datagrams between the real driver and the simulator, with faults, in virtual time.

It stands in for the event loop's UDP sockets, so both sides run as they are. Images pass beside it, as files do that a
companion computer serves.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

Address = tuple[str, int]
HOST = "127.0.0.1"
GCS: Address = (HOST, 14550)
FIRST_PORT = 40_000
"""Port of the first vehicle; each following one has the next."""


@dataclass
class Faults:
    """What happens to datagrams, both ways alike; probabilities per datagram."""

    loss: float = 0.0
    burst: float = 0.0
    """Probability that a burst of losses begins."""
    burst_length: float = 20.0
    """Mean number of datagrams lost in a row."""
    duplicate: float = 0.0
    reorder: float = 0.0
    """Probability of a delay that lets others overtake."""
    reorder_s: float = 0.3
    latency_s: float = 0.02
    corrupt: float = 0.0
    """Probability that a byte is changed."""


@dataclass
class Air:
    """The network, with one address per vehicle."""

    faults: Faults = field(default_factory=Faults)
    seed: int = 1
    cut: set[int] = field(default_factory=set)
    """Indices of vehicles that nothing reaches and that reach nobody."""
    sent_to: dict[int, list[bytes]] = field(default_factory=dict)
    """What the ground station has sent, by the index of the vehicle at that address."""
    on_datagram: Callable[[bytes, Address, Address], bytes | None] | None = None
    """Sees each datagram with sender and receiver; returns what becomes of it, None to drop it."""

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self._protocols: dict[Address, asyncio.DatagramProtocol] = {}
        self._in_burst: dict[tuple[Address, Address], bool] = {}
        self._next_port = FIRST_PORT

    def install(self, loop: asyncio.AbstractEventLoop) -> None:
        """Have the loop open its UDP endpoints here."""
        loop.create_datagram_endpoint = self._open  # type: ignore[method-assign, assignment]

    async def _open(
        self, factory: Callable[[], Any], local_addr: Address | None = None, remote_addr: Address | None = None
    ) -> tuple[Any, Any]:
        if local_addr is None:
            local_addr, self._next_port = (HOST, self._next_port), self._next_port + 1
        protocol = factory()
        self._protocols[local_addr] = protocol
        transport = _Transport(self, local_addr, remote_addr)
        protocol.connection_made(transport)
        return transport, protocol

    def close(self, address: Address) -> None:
        self._protocols.pop(address, None)

    def carry(self, data: bytes, sender: Address, receiver: Address) -> None:
        """Take a datagram, and deliver it or not."""
        if sender == GCS:
            self.sent_to.setdefault(receiver[1] - FIRST_PORT, []).append(data)
        if {sender[1] - FIRST_PORT, receiver[1] - FIRST_PORT} & self.cut:
            return
        seen = data if self.on_datagram is None else self.on_datagram(data, sender, receiver)
        if seen is None or self._is_lost((sender, receiver)):
            return
        for _ in range(2 if self._chance(self.faults.duplicate) else 1):
            late_s = self.faults.reorder_s if self._chance(self.faults.reorder) else 0.0
            delay_s = self.faults.latency_s + late_s
            asyncio.get_running_loop().call_later(delay_s, self._deliver, self._damaged(seen), sender, receiver)

    def _deliver(self, data: bytes, sender: Address, receiver: Address) -> None:
        protocol = self._protocols.get(receiver)
        if protocol is not None:
            protocol.datagram_received(data, sender)

    def _is_lost(self, way: tuple[Address, Address]) -> bool:
        faults = self.faults
        if self._in_burst.get(way, False):
            self._in_burst[way] = not self._chance(1.0 / faults.burst_length)
            return True
        self._in_burst[way] = self._chance(faults.burst)
        return self._in_burst[way] or self._chance(faults.loss)

    def _damaged(self, data: bytes) -> bytes:
        if not data or not self._chance(self.faults.corrupt):
            return data
        damaged = bytearray(data)
        damaged[self._rng.integers(len(damaged))] ^= int(self._rng.integers(1, 256))
        return bytes(damaged)

    def _chance(self, probability: float) -> bool:
        return probability > 0.0 and bool(self._rng.random() < probability)


class _Transport:
    """What the endpoints of driver and simulator ask of a datagram transport."""

    def __init__(self, air: Air, local: Address, remote: Address | None) -> None:
        self._air = air
        self._local = local
        self._remote = remote

    def sendto(self, data: bytes, addr: Address | None = None) -> None:
        receiver = addr if self._remote is None else self._remote
        assert receiver is not None
        self._air.carry(bytes(data), self._local, receiver)

    def get_extra_info(self, name: str) -> object:
        return {"peername": self._remote, "socket": _Socket()}.get(name)

    def get_write_buffer_size(self) -> int:
        return 0

    def close(self) -> None:
        self._air.close(self._local)


class _Socket:
    def fileno(self) -> int:
        """No descriptor: the system does not know of this socket."""
        return -1

    def setsockopt(self, *_: int) -> None:
        """Buffers do not matter here."""


def targets(datagrams: list[bytes]) -> set[int]:
    """Return the system ids that messages are addressed to; 0 is nobody in particular."""
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    messages = [message for data in datagrams for message in parser.parse_buffer(data) or []]
    return {getattr(message, "target_system", 0) for message in messages}
