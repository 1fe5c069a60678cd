"""Links: UDP, TCP and serial endpoints that hand over bytes with the address they came from."""

from __future__ import annotations

import asyncio
import errno
import math
import socket
from collections import deque
from collections.abc import Callable
from contextlib import AsyncExitStack, suppress
from typing import Protocol

from aos_drivers.background import BackgroundTasks
from aos_drivers.links.address import LinkAddress, PeerAddress
from aos_drivers.links.arrival import ARRIVAL_BYTES, ask_for_arrivals, time_in_socket_s
from aos_drivers.links.intake import MAX_DATAGRAM_BYTES
from aos_drivers.links.overload import OverloadWatch, dropped_datagrams, inode_of
from aos_drivers.links.serial_port import SerialEndpoint, serial_error
from aos_gcs.clock import machine_utc_s
from aos_gcs.errors import LinkError
from aos_gcs.ports import Clock

_RECEIVE_BUFFER_BYTES = 1024 * 1024
"""Bytes of a hundred vehicles in about a second: a station that cannot keep up loses packets, and shows no old ones."""
_SEND_BUFFER_BYTES = 256 * 1024
_PAUSE_S = 0.005
"""Time between two looks at a socket, when datagrams come closer together than this."""
_LONG_PAUSE_S = 0.02
"""The same while many come, those of a large swarm: a look takes as long as ten datagrams do."""
_MANY_PER_S = 1000.0
_FLOOD_PER_S = 10_000.0
"""So many are those of no swarm: they would fill the receive buffer in a long pause, and push those of vehicles out."""
_MOST_AT_ONCE = 64
"""Datagrams that are read in one go; then other work has its turn."""
_KEPT_PEERS = 1024
"""Addresses of senders that are kept made."""
_RECONNECT_PAUSE_S = 2.0
_CONNECT_TIMEOUT_S = 5.0
_UNANSWERED_S = 10.0
"""Time after which a connection over which nothing gets through is given up: TCP itself waits for ever longer, up to
two minutes after the network is back, and for a quarter of an hour in all."""


class Receiver(Protocol):
    """Whoever processes what is received."""

    def __call__(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        """Process bytes that came ``waited_s`` ago, in real seconds."""
        ...


def _nothing() -> None:
    """Leave nothing to be done after a reading."""


class Endpoint(Protocol):
    """An open link."""

    def send(self, data: bytes, peer: PeerAddress) -> None:
        """Send without waiting. Policy when the socket is full: the packet is lost, as on any radio."""
        ...


class UdpEndpoint(asyncio.DatagramProtocol):
    """A bound (``udpin``) or connected (``udpout``) UDP socket.

    To wake up takes longer than to read a packet. When datagrams come close together, asyncio, which wakes up for each
    one, is therefore paused, and they are read together every few milliseconds until none has come. How long each has
    waited by that is passed on with it; what this station is late beyond that is not.
    """

    def __init__(self, link: int, receive: Receiver, is_connected: bool, settle: Callable[[], None] = _nothing) -> None:
        """Pass datagrams on to ``receive``, and call ``settle`` after those that were read together."""
        self._link = link
        self._receive = receive
        self._settle = settle
        self._is_connected = is_connected
        self._transport: asyncio.DatagramTransport | None = None
        self._socket: socket.socket | None = None
        self._came_at_s = -math.inf
        self._next_read: asyncio.TimerHandle | None = None
        self._pause_s = _PAUSE_S
        self._taken = 0
        """Datagrams read since the last pause."""
        self._peers: dict[tuple[str, int], PeerAddress] = {}
        self._waiting: deque[tuple[bytes, list[tuple[int, int, bytes]], int, tuple[str, int]]] = deque()
        """Datagrams that are read and not passed on yet: none but in ``_take_waiting``, and after an error there."""

    def connection_made(self, transport: asyncio.DatagramTransport) -> None:  # type: ignore[override]
        """See asyncio."""
        self._transport = transport
        # asyncio's own transports can be paused; only their abstract class cannot, and other loops' may not.
        if hasattr(transport, "pause_reading"):
            # asyncio lends its socket for its options only; a copy can be read.
            self._socket = transport.get_extra_info("socket").dup()
            ask_for_arrivals(self._socket)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - asyncio's own
        """See asyncio."""
        if self._next_read is not None:
            self._next_read.cancel()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        """See asyncio."""
        if self._socket is not None:
            now_s = asyncio.get_running_loop().time()
            if now_s - self._came_at_s < _PAUSE_S:
                self._transport.pause_reading()  # type: ignore[union-attr]
                self._pause_s = _PAUSE_S
                self._read_after(_PAUSE_S, self._socket)
            self._came_at_s = now_s
        try:
            self._take(data, addr)
        finally:
            self._settle()

    def _read_after(self, pause_s: float, source: socket.socket) -> None:
        self._next_read = asyncio.get_running_loop().call_later(pause_s, self._read, source)

    def _read(self, source: socket.socket) -> None:
        """Read what has come; when nothing has, let asyncio wait for the next datagram."""
        taken = _MOST_AT_ONCE  # after an error, which is that of one datagram, go on with those behind it
        try:
            taken = self._take_waiting(source)
        finally:
            self._taken += taken
            if taken == _MOST_AT_ONCE:
                self._read_after(0.0, source)
            elif self._taken:
                are_many = _MANY_PER_S * self._pause_s <= self._taken < _FLOOD_PER_S * self._pause_s
                self._pause_s = _LONG_PAUSE_S if are_many else _PAUSE_S
                self._taken = 0
                self._read_after(self._pause_s, source)
            else:
                self._transport.resume_reading()  # type: ignore[union-attr]

    def _take_waiting(self, source: socket.socket) -> int:
        """Pass on the datagrams that wait, up to ``_MOST_AT_ONCE``, and return how many these were."""
        waiting = self._waiting
        with suppress(OSError):  # nothing waits, or a peer is unreachable: what waits behind that is read later
            while len(waiting) < _MOST_AT_ONCE:
                waiting.append(source.recvmsg(MAX_DATAGRAM_BYTES + 1, ARRIVAL_BYTES))
        taken, now_utc_s = len(waiting), machine_utc_s()
        try:
            while waiting:
                data, ancillary, _flags, address = waiting.popleft()
                self._take(data, address, time_in_socket_s(ancillary, now_utc_s, _LONG_PAUSE_S))
        finally:
            self._settle()
        return taken

    def _take(self, data: bytes, address: tuple[str, int], waited_s: float = 0.0) -> None:
        """Pass on a datagram; those larger than any bundle of packets are dropped."""
        if len(data) <= MAX_DATAGRAM_BYTES:
            self._receive(data, self._peers.get(address) or self._peer_of(address), waited_s)

    def _peer_of(self, address: tuple[str, int]) -> PeerAddress:
        if len(self._peers) >= _KEPT_PEERS:
            self._peers.clear()
        peer = self._peers[address] = PeerAddress(self._link, address[0], address[1])
        return peer

    def error_received(self, exc: Exception) -> None:
        """Ignore an unreachable peer: it may not have started yet."""

    def send(self, data: bytes, peer: PeerAddress) -> None:
        """See Endpoint."""
        # asyncio's transports have the method; only its abstract class lacks it.
        if self._transport is not None and self._transport.get_write_buffer_size() < _SEND_BUFFER_BYTES:  # type: ignore[attr-defined]
            self._transport.sendto(data, None if self._is_connected else (peer.host, peer.port))


class TcpEndpoint:
    """TCP connections of one link, ours (``tcpout``) or those of clients (``tcpin``)."""

    def __init__(self, link: int, receive: Receiver) -> None:
        self._link = link
        self._receive = receive
        self._writers: dict[PeerAddress, asyncio.StreamWriter] = {}

    def send(self, data: bytes, peer: PeerAddress) -> None:
        """See Endpoint."""
        writer = self._writers.get(peer)
        if writer is not None and writer.transport.get_write_buffer_size() < _SEND_BUFFER_BYTES:
            writer.write(data)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Pass on the bytes of one connection until it ends."""
        peer = _peer_of(self._link, writer)
        if peer is None:
            writer.close()
            return
        connection = writer.get_extra_info("socket")
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
        if hasattr(socket, "TCP_USER_TIMEOUT"):  # on Linux
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, round(_UNANSWERED_S * 1e3))
        self._writers[peer] = writer
        try:
            while data := await reader.read(4096):
                self._receive(data, peer)
        except OSError:
            pass  # a broken connection ends like a closed one
        finally:
            del self._writers[peer]
            writer.close()

    def close(self) -> None:
        """Close all connections."""
        for writer in self._writers.values():
            writer.close()


class LinkOpener:
    """Opens links into an exit stack; their background work runs in ``tasks``."""

    def __init__(
        self,
        stack: AsyncExitStack,
        tasks: BackgroundTasks,
        clock: Clock,
        receive: Receiver,
        on_change: Callable[[str], None],
        *,
        settle: Callable[[], None] = _nothing,
    ) -> None:
        """Pass what is received on to ``receive``, and call ``settle`` after what was read together.

        ``on_change`` is called with a sentence when a connection or device is lost or restored.
        """
        self._stack = stack
        self._tasks = tasks
        self._clock = clock
        self._receive = receive
        self._on_change = on_change
        self._settle = settle

    async def open(self, link: int, address: LinkAddress) -> tuple[Endpoint, PeerAddress | None]:
        """Return the endpoint and, for links that call out, its peer.

        Raises:
            LinkError: the socket cannot be opened.
        """
        if address.kind == "serial":
            return self._open_serial(link, address)
        try:
            if address.kind.startswith("udp"):
                return await self._open_udp(link, address)
            if address.kind == "tcpout":
                return await self._open_tcp_client(link, address)
            return await self._open_tcp_server(link, address)
        except TimeoutError:
            raise LinkError(f"{address.text} does not respond: check address and network") from None
        except OSError as error:
            raise _link_error(address, error) from error

    def _receive_alone(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        try:
            self._receive(data, peer, waited_s)
        finally:
            self._settle()

    async def _open_udp(self, link: int, address: LinkAddress) -> tuple[Endpoint, PeerAddress | None]:
        loop = asyncio.get_running_loop()
        where = (address.host, address.port)
        is_connected = address.kind == "udpout"
        transport, endpoint = await loop.create_datagram_endpoint(
            lambda: UdpEndpoint(link, self._receive, is_connected, self._settle),
            local_addr=None if is_connected else where,
            remote_addr=where if is_connected else None,
        )
        self._stack.callback(transport.close)
        udp_socket = transport.get_extra_info("socket")
        udp_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
        inode = inode_of(udp_socket.fileno())
        if inode is not None:
            watch = OverloadWatch(address.text, lambda: dropped_datagrams(inode), self._on_change)
            self._tasks.start(watch.run(self._clock))
        if not is_connected:
            return endpoint, None
        host, port = transport.get_extra_info("peername")[:2]
        return endpoint, PeerAddress(link, host, port)

    def _open_serial(self, link: int, address: LinkAddress) -> tuple[Endpoint, PeerAddress]:
        endpoint = SerialEndpoint(link, address, self._receive_alone)
        try:
            endpoint.open()
        except OSError as error:
            raise serial_error(address, error) from error
        self._stack.callback(endpoint.close)
        self._tasks.start(self._keep_open(endpoint, address))
        return endpoint, endpoint.peer

    async def _keep_open(self, endpoint: SerialEndpoint, address: LinkAddress) -> None:
        while True:
            await endpoint.wait_until_lost()
            self._on_change(f"{address.text} lost; reconnecting")
            while not await self._reopen(endpoint):
                pass
            self._on_change(f"{address.text} restored")

    async def _reopen(self, endpoint: SerialEndpoint) -> bool:
        await self._clock.sleep(_RECONNECT_PAUSE_S)
        try:
            endpoint.open()
        except OSError:
            return False
        return True

    async def _open_tcp_server(self, link: int, address: LinkAddress) -> tuple[Endpoint, None]:
        endpoint = TcpEndpoint(link, self._receive_alone)
        server = await asyncio.start_server(endpoint.serve, address.host, address.port)
        self._stack.callback(server.close)
        self._stack.callback(endpoint.close)
        return endpoint, None

    async def _open_tcp_client(self, link: int, address: LinkAddress) -> tuple[Endpoint, PeerAddress]:
        endpoint = TcpEndpoint(link, self._receive_alone)
        async with asyncio.timeout(_CONNECT_TIMEOUT_S):
            reader, writer = await asyncio.open_connection(address.host, address.port)
        peer = _peer_of(link, writer)
        if peer is None:
            raise LinkError(f"{address.text} does not respond: check address and network")
        self._stack.callback(endpoint.close)
        self._tasks.start(self._keep_connected(endpoint, address, reader, writer))
        return endpoint, peer

    async def _keep_connected(
        self, endpoint: TcpEndpoint, address: LinkAddress, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        while True:
            await endpoint.serve(reader, writer)
            self._on_change(f"{address.text} lost; reconnecting")
            reader, writer = await self._reconnect(address)
            self._on_change(f"{address.text} restored")

    async def _reconnect(self, address: LinkAddress) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        while True:
            await self._clock.sleep(_RECONNECT_PAUSE_S)
            with suppress(OSError):
                async with asyncio.timeout(_CONNECT_TIMEOUT_S):
                    return await asyncio.open_connection(address.host, address.port)


def _peer_of(link: int, writer: asyncio.StreamWriter) -> PeerAddress | None:
    """Return the address at the other end of a connection; None where that has ended it already."""
    name = writer.get_extra_info("peername")
    return None if name is None else PeerAddress(link, *name[:2])


def _link_error(address: LinkAddress, error: OSError) -> LinkError:
    if error.errno == errno.EADDRINUSE:
        return LinkError(
            f"port {address.port} is in use: stop the other ground station or choose another port ({address.text})"
        )
    return LinkError(f"{address.text} cannot be opened: {error.strerror or error}")
