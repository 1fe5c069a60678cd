"""Reading of UDP links: datagrams that come close together are read together."""

from __future__ import annotations

import asyncio
import socket
import struct
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.arrival import ARRIVAL_BYTES, ask_for_arrivals, time_in_socket_s
from aos_drivers.links.intake import MAX_DATAGRAM_BYTES
from aos_drivers.links.opener import Receiver, UdpEndpoint


def test_a_datagram_larger_than_any_bundle_of_packets_is_dropped() -> None:
    received: list[bytes] = []
    endpoint = UdpEndpoint(0, lambda data, _peer, _waited_s=0.0: received.append(data), is_connected=False)
    for size in (MAX_DATAGRAM_BYTES, MAX_DATAGRAM_BYTES + 1, 65_000):
        endpoint.datagram_received(bytes(size), ("10.6.6.6", 1))
    assert [len(data) for data in received] == [MAX_DATAGRAM_BYTES]


async def test_all_datagrams_are_read_in_order_but_for_oversized_ones() -> None:
    received: list[tuple[bytes, PeerAddress]] = []
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
        lambda: UdpEndpoint(3, lambda data, peer, _waited_s=0.0: received.append((data, peer)), is_connected=False),
        local_addr=("127.0.0.1", 0),
    )
    contents = [bytes([number]) for number in range(40)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(transport.get_extra_info("sockname"))
        peer = PeerAddress(3, *sender.getsockname())
        for last in (b"a", b"b"):
            for content in (*contents, bytes(MAX_DATAGRAM_BYTES + 1), last):
                sender.send(content)
            while not received or received[-1] != (last, peer):  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0)
    transport.close()
    await asyncio.sleep(0)
    assert received == [(content, peer) for content in (*contents, b"a", *contents, b"b")]


class Transport:
    """What an endpoint asks of asyncio's transport: a socket to read, and whether asyncio reads it, too."""

    def __init__(self, lent: socket.socket) -> None:
        self.lent = lent
        self.is_reading = True

    def get_extra_info(self, _name: str) -> socket.socket:
        return self.lent

    def pause_reading(self) -> None:
        self.is_reading = False

    def resume_reading(self) -> None:
        self.is_reading = True


@dataclass
class Exchange:
    """An endpoint on a socket, and a vehicle that it is connected to."""

    endpoint: UdpEndpoint
    transport: Transport
    vehicle: socket.socket

    def deliver(self, *contents: bytes) -> None:
        """Send to the endpoint; those that wait while asyncio reads are passed on as asyncio does."""
        for content in contents:
            self.vehicle.send(content)
            if self.transport.is_reading:
                self.endpoint.datagram_received(*self.transport.lent.recvfrom(MAX_DATAGRAM_BYTES))


def nothing() -> None:
    pass


@contextmanager
def exchange(receive: Receiver, settle: Callable[[], None] = nothing) -> Iterator[Exchange]:
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as lent,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle,
    ):
        for each in (lent, vehicle):
            each.bind(("127.0.0.1", 0))
        lent.connect(vehicle.getsockname())
        vehicle.connect(lent.getsockname())
        lent.setblocking(False)
        endpoint, transport = UdpEndpoint(0, receive, is_connected=True, settle=settle), Transport(lent)
        endpoint.connection_made(transport)  # type: ignore[arg-type]
        yield Exchange(endpoint, transport, vehicle)
        endpoint.connection_lost(None)


def collect_errors() -> list[Exception]:
    """Return the list of errors that the event loop reports from now on."""
    errors: list[Exception] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: errors.append(context["exception"]))
    return errors


@pytest.mark.looptime
async def test_datagrams_far_apart_are_read_as_they_come() -> None:
    received: list[bytes] = []
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        for number in range(3):
            link.deliver(bytes([number]))
            assert len(received) == number + 1
            assert link.transport.is_reading
            await asyncio.sleep(0.006)


@pytest.mark.looptime
async def test_datagrams_close_together_are_read_together_and_not_without_end() -> None:
    received: list[bytes] = []
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        link.deliver(*(bytes([number]) for number in range(70)))
        assert len(received) == 2
        assert not link.transport.is_reading
        await asyncio.sleep(0.004)
        assert len(received) == 2
        await asyncio.sleep(0.001)
        assert len(received) == 2 + 64
        await asyncio.sleep(0.0)
        assert received == [bytes([number]) for number in range(70)]
        assert not link.transport.is_reading
        await asyncio.sleep(0.006)
        assert link.transport.is_reading


@pytest.mark.looptime
async def test_the_datagrams_of_a_large_swarm_are_read_less_often() -> None:
    received: list[bytes] = []
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        link.deliver(*[b"many"] * 12)
        await asyncio.sleep(0.006)
        assert len(received) == 12
        link.deliver(b"few")
        await asyncio.sleep(0.018)
        assert len(received) == 12
        await asyncio.sleep(0.002)
        assert received[12:] == [b"few"]
        link.deliver(b"again")
        await asyncio.sleep(0.005)
        assert received[13:] == [b"again"]


@pytest.mark.looptime
async def test_a_flood_is_read_more_often_than_a_large_swarm() -> None:
    received: list[bytes] = []
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        link.deliver(*[b"many"] * 12)
        await asyncio.sleep(0.006)
        link.deliver(*[b"more"] * 230)
        await asyncio.sleep(0.02)
        assert len(received) == 242
        link.deliver(b"next")
        await asyncio.sleep(0.005)
        assert received[242:] == [b"next"]


@contextmanager
def arrivals_told() -> Iterator[None]:
    """Have the kernel note arrivals: it begins a moment after the first socket asks, and ends with the last one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as source:
        source.bind(("127.0.0.1", 0))
        ask_for_arrivals(source)
        waited_s = 0.0
        while waited_s == 0.0:
            source.sendto(b"", source.getsockname())
            sent_s = time.time()
            time.sleep(0.001)
            _, ancillary, _, _ = source.recvmsg(1, ARRIVAL_BYTES)
            waited_s = time_in_socket_s(ancillary, sent_s, 1.0)
        yield


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells when datagrams arrive")
@pytest.mark.looptime
async def test_how_long_a_datagram_waited_is_passed_on_with_it() -> None:
    waited_s: list[float] = []
    with arrivals_told(), exchange(lambda _data, _peer, time_s=0.0: waited_s.append(time_s)) as link:
        link.deliver(*[b"at once"] * 2)
        link.deliver(b"waits")
        time.sleep(0.002)  # noqa: ASYNC251 - the kernel's clock is no virtual one
        await asyncio.sleep(0.006)
    assert waited_s[:2] == [0.0, 0.0]
    assert 0.002 <= waited_s[2] <= 0.02


def test_a_waiting_time_is_bounded_and_zero_where_it_is_not_known() -> None:
    option, now_s = (socket.SOL_SOCKET, 35), 1_800_000_000.0
    assert time_in_socket_s([], now_s, 0.02) == 0.0
    assert time_in_socket_s([(*option, b"short")], now_s, 0.02) == 0.0
    assert time_in_socket_s([(socket.SOL_SOCKET, 29, struct.pack("@ll", 1_799_999_991, 0))], now_s, 0.02) == 0.0
    assert time_in_socket_s([(*option, struct.pack("@ll", 1_799_999_991, 0))], now_s, 0.02) == 0.02
    assert time_in_socket_s([(*option, struct.pack("@ll", 1_800_000_009, 0))], now_s, 0.02) == 0.0


@pytest.mark.looptime
async def test_an_error_in_the_handling_of_a_datagram_does_not_end_the_reading() -> None:
    received: list[bytes] = []

    def receive(data: bytes, _peer: PeerAddress, _waited_s: float = 0.0, /) -> None:
        if data == b"bad":
            raise ValueError("an error of ours")
        received.append(data)

    errors = collect_errors()
    with exchange(receive) as link:
        link.deliver(b"a", b"b", b"c", b"bad", b"d")
        await asyncio.sleep(0.006)
        assert received == [b"a", b"b", b"c", b"d"]
        assert list(map(str, errors)) == ["an error of ours"]
        await asyncio.sleep(0.006)
        with pytest.raises(ValueError, match="an error of ours"):
            link.deliver(b"e", b"bad")
        link.deliver(b"f")
        await asyncio.sleep(0.006)
        assert received == [b"a", b"b", b"c", b"d", b"e", b"f"]


@pytest.mark.looptime
async def test_what_was_read_together_is_settled_together_after_an_error_too() -> None:
    events: list[str] = []

    def receive(data: bytes, _peer: PeerAddress, _waited_s: float = 0.0, /) -> None:
        events.append(data.decode())
        if data == b"bad":
            raise ValueError("an error of ours")

    errors = collect_errors()
    with exchange(receive, lambda: events.append("|")) as link:
        link.deliver(b"a", b"b")
        assert events == ["a", "|", "b", "|"]
        events.clear()
        link.deliver(b"c", b"d", b"bad", b"e", b"f")
        await asyncio.sleep(0.004)
        assert events == []
        await asyncio.sleep(0.002)
        assert events[:8] == ["c", "d", "bad", "|", "e", "f", "|"]
        assert len(errors) == 1


@pytest.mark.looptime
async def test_a_vehicle_that_stops_and_starts_again_is_read_again() -> None:
    received: list[bytes] = []
    errors = collect_errors()
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        link.deliver(b"a", b"b")
        address = link.vehicle.getsockname()
        link.vehicle.close()
        link.transport.lent.send(b"nobody hears it, and the network says so")
        await asyncio.sleep(0.006)
        assert link.transport.is_reading
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link.vehicle:
            link.vehicle.bind(address)
            link.vehicle.connect(link.transport.lent.getsockname())
            link.deliver(b"c")
    assert received == [b"a", b"b", b"c"]
    assert not errors


@pytest.mark.looptime
async def test_a_closed_endpoint_reads_no_more() -> None:
    received: list[bytes] = []
    with exchange(lambda data, _peer, _waited_s=0.0: received.append(data)) as link:
        link.deliver(b"a", b"b", b"c")
        link.endpoint.connection_lost(None)
        await asyncio.sleep(0.01)
        assert received == [b"a", b"b"]
        assert not link.transport.is_reading
