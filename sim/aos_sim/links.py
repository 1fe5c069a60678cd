"""MAVLink connections of the simulated vehicles: one socket per vehicle, so that source ports tell them apart."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any
from urllib.parse import urlsplit

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError, LinkError

MAX_PEERS = 8
MAX_BACKLOG_BYTES = 65_536

OnMessage = Callable[[mavlink.MAVLink_message], None]
Address = tuple[str, int]


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
    """Where the vehicles connect to, or listen."""

    kind: LinkKind
    host: str
    port: int

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
            raise ConfigurationError(f"--link {url} is not of the form KIND://HOST:PORT with KIND one of {kinds}.")
        return cls(kind, host, port)

    def for_vehicle(self, index: int) -> LinkAddress:
        """Return the address for the vehicle with this place in the swarm, from 0."""
        listens = self.kind in (LinkKind.UDP_IN, LinkKind.TCP_IN)
        return LinkAddress(self.kind, self.host, self.port + index if listens else self.port)


class Parser:
    """Bytes of one peer to messages; what is damaged or unknown is skipped."""

    def __init__(self) -> None:
        self._codec = mavlink.MAVLink(None)
        self._codec.robust_parsing = True

    def feed(self, data: bytes) -> list[mavlink.MAVLink_message]:
        """Return the messages completed by ``data``."""
        messages = self._codec.parse_buffer(data) or []
        return [message for message in messages if message.get_msgId() >= 0]


class Endpoint(ABC):
    """One vehicle's end of a link."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Send to all peers at once; what a peer cannot take now is dropped, as on a radio."""

    @abstractmethod
    def close(self) -> None:
        """Close the sockets."""


class UdpEndpoint(Endpoint, asyncio.DatagramProtocol):
    """UDP, either connected to one address or answering all who have sent (the latest eight)."""

    def __init__(self, on_message: OnMessage) -> None:
        self._on_message = on_message
        self._transport: asyncio.DatagramTransport | None = None
        self._connected = False
        self._parsers: OrderedDict[Address, Parser] = OrderedDict()

    def connection_made(self, transport: asyncio.DatagramTransport) -> None:  # type: ignore[override]
        """Note the socket."""
        self._transport = transport
        self._connected = transport.get_extra_info("peername") is not None

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        """Parse what a peer has sent."""
        parser = self._parsers.setdefault(addr, Parser())
        self._parsers.move_to_end(addr)
        if len(self._parsers) > MAX_PEERS:
            self._parsers.popitem(last=False)
        for message in parser.feed(data):
            self._on_message(message)

    def error_received(self, exc: Exception) -> None:
        """Ignore "connection refused": nobody listens yet, and the vehicles go on sending."""

    def send(self, data: bytes) -> None:
        """Send to the connected address or to all peers."""
        if self._transport is None:
            return
        if self._connected:
            self._transport.sendto(data)
            return
        for address in self._parsers:
            self._transport.sendto(data, address)

    def close(self) -> None:
        """Close the socket."""
        if self._transport is not None:
            self._transport.close()


class TcpEndpoint(Endpoint):
    """TCP, for one connection made or several accepted."""

    def __init__(self, on_message: OnMessage) -> None:
        self._on_message = on_message
        self.server: asyncio.Server | None = None
        self._transports: set[asyncio.Transport] = set()

    def make_protocol(self) -> asyncio.Protocol:
        """Return the protocol of one connection."""
        return _TcpConnection(self._on_message, self._transports)

    def send(self, data: bytes) -> None:
        """Send on all connections."""
        for transport in self._transports:
            if transport.get_write_buffer_size() < MAX_BACKLOG_BYTES:
                transport.write(data)

    def close(self) -> None:
        """Stop to listen and close the connections."""
        if self.server is not None:
            self.server.close()
        for transport in tuple(self._transports):
            transport.close()


class _TcpConnection(asyncio.Protocol):
    def __init__(self, on_message: OnMessage, transports: set[asyncio.Transport]) -> None:
        self._on_message = on_message
        self._transports = transports
        self._transport: asyncio.Transport | None = None
        self._parser = Parser()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        self._transport = transport
        self._transports.add(transport)

    def data_received(self, data: bytes) -> None:
        for message in self._parser.feed(data):
            self._on_message(message)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - the reason changes nothing
        if self._transport is not None:
            self._transports.discard(self._transport)


async def open_endpoint(address: LinkAddress, on_message: OnMessage) -> Endpoint:
    """Open one vehicle's end of a link; the caller closes it.

    Raises:
        LinkError: the port is taken, or nobody answers at a TCP address.
    """
    loop = asyncio.get_running_loop()
    where = (address.host, address.port)
    try:
        if address.kind in (LinkKind.UDP_OUT, LinkKind.UDP_IN):
            side = "remote_addr" if address.kind is LinkKind.UDP_OUT else "local_addr"
            _, udp = await loop.create_datagram_endpoint(lambda: UdpEndpoint(on_message), **{side: where})  # type: ignore[arg-type]
            return udp
        tcp = TcpEndpoint(on_message)
        if address.kind is LinkKind.TCP_OUT:
            await loop.create_connection(tcp.make_protocol, *where)
        else:
            tcp.server = await loop.create_server(tcp.make_protocol, *where)
    except OSError as error:
        raise LinkError(
            f"Cannot open {address.kind}://{address.host}:{address.port}: {error.strerror or error}. "
            "Close the program that uses the port or choose another --link."
        ) from error
    return tcp
