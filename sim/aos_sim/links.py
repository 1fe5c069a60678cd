"""MAVLink connections of simulated vehicles and cameras: bytes and messages over UDP and TCP."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from urllib.parse import urlsplit

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError, LinkError
from aos_sim.packets import Parser

GROUND_STATIONS = 8
"""Peers of a vehicle that listens."""
MAX_BACKLOG_BYTES = 65_536
MAX_PORT = 65_535

Address = tuple[str, int]
OnMessage = Callable[[mavlink.MAVLink_message, Address], None]
"""Takes a message and who has sent it."""


class LinkKind(StrEnum):
    """Ways to connect."""

    UDP_OUT = "udpout"
    """Every vehicle sends to the address from a port of its own."""
    UDP_IN = "udpin"
    """Vehicle i listens on port + i and answers whoever has sent to it."""
    TCP_OUT = "tcpout"
    """Every vehicle opens a connection to the address."""
    TCP_IN = "tcpin"
    """Vehicle i accepts connections on port + i."""


@dataclass(frozen=True, slots=True)
class LinkAddress:
    """Addresses to which the vehicles connect, or on which they listen."""

    kind: LinkKind
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.kind}://{self.host}:{self.port}"

    @classmethod
    def parse(cls, url: str) -> LinkAddress:
        """Read ``udpout://127.0.0.1:14550`` and the like.

        Raises:
            ConfigurationError: the text is not such a URL.
        """
        try:
            parts = urlsplit(url)
            kind, host, port = LinkKind(parts.scheme), parts.hostname, parts.port
        except ValueError:
            kind, host, port = LinkKind.UDP_OUT, None, None
        if not host or not port or parts.path not in ("", "/"):
            kinds = ", ".join(LinkKind)
            raise ConfigurationError(f"The link {url} is not of the form KIND://HOST:PORT with KIND one of {kinds}.")
        return cls(kind, host, port)

    def for_vehicle(self, index: int) -> LinkAddress:
        """Return the address for the vehicle with this place in the swarm, from 0.

        Raises:
            ConfigurationError: there is no such port.
        """
        listens = self.kind in (LinkKind.UDP_IN, LinkKind.TCP_IN)
        port = self.port + index if listens else self.port
        if port > MAX_PORT:
            raise ConfigurationError(f"The link {self} has no port for vehicle {index + 1}: ports end at {MAX_PORT}.")
        return LinkAddress(self.kind, self.host, port)


class Endpoint(ABC):
    """One end of a link."""

    def __init__(self) -> None:
        self._lost = asyncio.Event()

    @abstractmethod
    def send(self, data: bytes, to: Address | None = None) -> None:
        """Send to one peer, or to all; what a peer cannot take now is dropped, as on a radio."""

    async def wait_until_lost(self) -> None:
        """Wait until the connection that was made has ended; forever where there is none."""
        await self._lost.wait()

    @abstractmethod
    def close(self) -> None:
        """Close the sockets."""


class UdpEndpoint(Endpoint, asyncio.DatagramProtocol):
    """UDP, either connected to one address or answering all who have sent (the latest ``max_peers``)."""

    def __init__(self, on_message: OnMessage, max_peers: int) -> None:
        super().__init__()
        self._max_peers = max_peers
        self._on_message = on_message
        self._transport: asyncio.DatagramTransport | None = None
        self._connected = False
        self._parsers: OrderedDict[Address, Parser] = OrderedDict()

    def connection_made(self, transport: asyncio.DatagramTransport) -> None:  # type: ignore[override]
        """Note the socket."""
        self._transport = transport
        self._connected = transport.get_extra_info("peername") is not None

    def datagram_received(self, data: bytes, addr: Address) -> None:
        """Parse what a peer has sent."""
        parser = self._parsers.setdefault(addr, Parser())
        self._parsers.move_to_end(addr)
        if len(self._parsers) > self._max_peers:
            self._parsers.popitem(last=False)
        for message in parser.feed(data):
            self._on_message(message, addr)

    def error_received(self, exc: Exception) -> None:
        """Ignore "connection refused": nobody listens yet, and the vehicles go on sending."""

    def send(self, data: bytes, to: Address | None = None) -> None:
        """Send to the connected address, or to one peer or all."""
        if self._transport is None:
            return
        if self._connected:
            self._transport.sendto(data)
            return
        for address in self._parsers if to is None else (to,):
            self._transport.sendto(data, address)

    def close(self) -> None:
        """Close the socket."""
        if self._transport is not None:
            self._transport.close()


class TcpEndpoint(Endpoint):
    """TCP, for one connection made or several accepted."""

    def __init__(self, on_message: OnMessage) -> None:
        super().__init__()
        self._on_message = on_message
        self.server: asyncio.Server | None = None
        self._transports: dict[Address, asyncio.Transport] = {}

    def make_protocol(self) -> asyncio.Protocol:
        """Return the protocol of one connection."""
        return _TcpConnection(self._on_message, self._transports, self._on_end)

    def send(self, data: bytes, to: Address | None = None) -> None:
        """Send on the connection to one peer, or on all."""
        for address, transport in self._transports.items():
            if to in (None, address) and transport.get_write_buffer_size() < MAX_BACKLOG_BYTES:
                transport.write(data)

    def close(self) -> None:
        """Stop to listen and close the connections."""
        if self.server is not None:
            self.server.close()
        for transport in tuple(self._transports.values()):
            transport.close()

    def _on_end(self) -> None:
        if self.server is None:
            self._lost.set()


class _TcpConnection(asyncio.Protocol):
    def __init__(
        self, on_message: OnMessage, transports: dict[Address, asyncio.Transport], on_end: Callable[[], None]
    ) -> None:
        self._on_message = on_message
        self._transports = transports
        self._on_end = on_end
        self._peer: Address = ("", 0)
        self._parser = Parser()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        host, port = transport.get_extra_info("peername")[:2]
        self._peer = (host, port)
        self._transports[self._peer] = transport

    def data_received(self, data: bytes) -> None:
        for message in self._parser.feed(data):
            self._on_message(message, self._peer)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - the reason changes nothing
        self._transports.pop(self._peer, None)
        self._on_end()


async def open_endpoint(address: LinkAddress, on_message: OnMessage, max_peers: int = GROUND_STATIONS) -> Endpoint:
    """Open one end of a link; the caller closes it.

    Raises:
        LinkError: the port is taken, or nobody answers at a TCP address.
    """
    loop = asyncio.get_running_loop()
    where = (address.host, address.port)
    try:
        if address.kind in (LinkKind.UDP_OUT, LinkKind.UDP_IN):
            side = "remote_addr" if address.kind is LinkKind.UDP_OUT else "local_addr"
            _, udp = await loop.create_datagram_endpoint(lambda: UdpEndpoint(on_message, max_peers), **{side: where})  # type: ignore[arg-type]
            return udp
        tcp = TcpEndpoint(on_message)
        if address.kind is LinkKind.TCP_OUT:
            await loop.create_connection(tcp.make_protocol, *where)
        else:
            tcp.server = await loop.create_server(tcp.make_protocol, *where)
    except OSError as error:
        if address.kind is LinkKind.TCP_OUT:
            raise LinkError(
                f"No answer at {address}: start the program that listens there, or correct the link."
            ) from error
        raise LinkError(
            f"Cannot open {address}: {error.strerror or error}. "
            "Close the program that uses the port or choose another --link."
        ) from error
    return tcp
