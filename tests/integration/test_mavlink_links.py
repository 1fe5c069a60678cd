"""The driver on real sockets of the loopback interface."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import struct
import termios
import tty
from collections.abc import Callable
from pathlib import Path

import pytest
import serial
from pymavlink import mavutil

from aos_drivers.links.address import PeerAddress, parse_link
from aos_drivers.links.opener import TcpEndpoint
from aos_drivers.links.recorder import TLOG_NAME
from aos_drivers.links.serial_port import SerialEndpoint
from aos_drivers.mavlink import open_mavlink
from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandRefusedError, ConfigurationError, LinkError
from aos_gcs.ports import DriverContext, Fleet, Hold, Land, Notice, Severity
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fakes.program import unused_port
from tests.timing import scaled_s

HOST = "127.0.0.1"
KEY = bytes(range(32))
PATIENT_S = 900.0
"""Deadline in clock seconds, ten to a real one, for what happens at once on an idle machine."""


def make_context(**settings: object) -> tuple[DriverContext, list[Notice]]:
    notices: list[Notice] = []
    return DriverContext(LoopClock(10.0), lambda: True, notices.append, **settings), notices  # type: ignore[arg-type]


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(scaled_s(30.0)):
        while not condition():  # noqa: ASYNC110 - what is awaited is the driver's telemetry
            await asyncio.sleep(0.005)


class UdpVehicle(asyncio.DatagramProtocol):
    """A fake vehicle behind a UDP socket."""

    def __init__(self, system_id: int) -> None:
        self.vehicle = FakeVehicle(system_id)

    def connection_made(self, transport: asyncio.DatagramTransport) -> None:  # type: ignore[override]
        self.transport = transport

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        answers = self.vehicle.hear(data)
        self.transport.sendto(answers + self.vehicle.telemetry(), addr)


async def open_vehicle(system_id: int, *, driver_port: int | None = None) -> UdpVehicle:
    loop = asyncio.get_running_loop()
    remote = (HOST, driver_port) if driver_port is not None else None
    local = (HOST, 0) if remote is None else None
    _transport, protocol = await loop.create_datagram_endpoint(
        lambda: UdpVehicle(system_id), local_addr=local, remote_addr=remote
    )
    return protocol


async def test_vehicles_on_one_udp_port_get_their_own_commands_and_all_is_logged(tmp_path: Path) -> None:
    context, _notices = make_context(log_folder=tmp_path)
    port = unused_port()
    async with open_mavlink([f"udpin://{HOST}:{port}"], context) as fleet:
        peers = [await open_vehicle(number, driver_port=port) for number in (1, 2, 3)]
        for peer in peers:
            peer.transport.sendto(peer.vehicle.telemetry())
        await until(lambda: set(fleet.vehicles()) == {1, 2, 3})
        await fleet.vehicles()[2].execute(Land(), context.clock.now_s() + PATIENT_S)
        assert [peer.vehicle.custom_mode for peer in peers] == [0, 9, 0]
        await until(lambda: all(peer.vehicle.heard_heartbeats > 1 for peer in peers))
        for number, peer in enumerate(peers, 1):
            assert {message.target_system for message in peer.vehicle.commands} == {number}
            peer.transport.close()
    log = mavutil.mavlink_connection(str(tmp_path / TLOG_NAME))
    messages = iter(log.recv_match, None)
    seen = {(message.get_srcSystem(), message.get_type()) for message in messages}
    log.close()
    assert {(254, "HEARTBEAT"), (254, "COMMAND_LONG"), (2, "COMMAND_ACK"), (3, "GLOBAL_POSITION_INT")} <= seen


async def test_udpout_calls_a_vehicle_that_waits() -> None:
    context, _notices = make_context()
    peer = await open_vehicle(4)
    port = peer.transport.get_extra_info("sockname")[1]
    async with open_mavlink([f"udpout://{HOST}:{port}"], context) as fleet:
        await until(lambda: 4 in fleet.vehicles())
    peer.transport.close()


async def talk_tcp(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, vehicle: FakeVehicle) -> None:
    writer.write(vehicle.telemetry())
    # A driver that closes while our telemetry is on its way resets the connection, or breaks it, instead of ending it.
    with contextlib.suppress(ConnectionError):
        while data := await reader.read(4096):
            writer.write(vehicle.hear(data) + vehicle.telemetry())
    writer.close()


async def test_tcpout_comes_back_after_a_broken_connection() -> None:
    context, notices = make_context()
    vehicle = FakeVehicle(5)
    connections: list[asyncio.StreamWriter] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        connections.append(writer)
        await talk_tcp(reader, writer, vehicle)

    async with await asyncio.start_server(serve, HOST, 0) as server:
        port = server.sockets[0].getsockname()[1]
        async with open_mavlink([f"tcp://{HOST}:{port}"], context) as fleet:
            await until(lambda: 5 in fleet.vehicles())
            connections[0].close()
            await until(lambda: len(connections) == 2)
            heard_at_s = fleet.vehicles()[5].state.heard_at_s
            await until(lambda: fleet.vehicles()[5].state.heard_at_s != heard_at_s)
            await fleet.vehicles()[5].execute(Land(), context.clock.now_s() + PATIENT_S)
    assert [notice.text for notice in notices if "lost; reconnecting" in notice.text]


async def test_tcpin_serves_vehicles_that_call() -> None:
    context, _notices = make_context()
    port = unused_port(socket.SOCK_STREAM)
    async with open_mavlink([f"tcpin://{HOST}:{port}"], context) as fleet:
        reader, writer = await asyncio.open_connection(HOST, port)
        talking = asyncio.create_task(talk_tcp(reader, writer, FakeVehicle(6)))
        await until(lambda: 6 in fleet.vehicles())
        await fleet.vehicles()[6].execute(Land(), context.clock.now_s() + PATIENT_S)
    await talking


async def test_a_signed_link_commands_a_vehicle_that_verifies_and_ignores_one_that_does_not_sign(
    tmp_path: Path,
) -> None:
    context, notices = make_context()
    key_file = tmp_path / "mavlink.key"
    key_file.touch(mode=0o600)
    key_file.write_text(KEY.hex())
    port = unused_port()
    async with open_mavlink([f"udpin://{HOST}:{port}?sign={key_file}"], context) as fleet:
        signing, unsigned = await open_vehicle(1, driver_port=port), await open_vehicle(2, driver_port=port)
        signing.vehicle.encoder.sign(KEY, context.clock.utc_s())
        for peer in (unsigned, signing):
            peer.transport.sendto(peer.vehicle.telemetry())
        await until(lambda: 1 in fleet.vehicles())
        await fleet.vehicles()[1].execute(Land(), context.clock.now_s() + PATIENT_S)
        assert set(fleet.vehicles()) == {1}
        assert any("system id 2" in notice.text and "not signed" in notice.text for notice in notices)
        for peer in (unsigned, signing):
            peer.transport.close()
    assert int((tmp_path / "mavlink.key.time").read_text()) > 0


async def test_a_vehicle_on_two_links_is_commanded_over_the_one_that_lives() -> None:
    context, notices = make_context()
    ports = [unused_port(), unused_port()]
    vehicle = FakeVehicle(1)
    async with open_mavlink([f"udpin://{HOST}:{port}" for port in ports], context) as fleet:
        ends = [await open_vehicle(1, driver_port=port) for port in ports]
        for end in ends:
            end.vehicle = vehicle

        async def speak() -> None:
            while True:
                packets = vehicle.telemetry()
                for end in ends:
                    end.transport.sendto(packets)
                await asyncio.sleep(0.01)

        speaking = asyncio.create_task(speak())
        await until(lambda: 1 in fleet.vehicles() and living_addresses(fleet) == 2)
        await fleet.vehicles()[1].execute(Hold(), context.clock.now_s() + PATIENT_S)
        ends.pop(0).transport.close()
        await until(lambda: any("is now reached at" in notice.text for notice in notices))
        await fleet.vehicles()[1].execute(Land(), context.clock.now_s() + PATIENT_S)
        speaking.cancel()
        ends[0].transport.close()
    assert [notice for notice in notices if notice.severity is Severity.CRITICAL] == []


def living_addresses(fleet: Fleet) -> int:
    link = fleet.vehicles()[1].state.link
    return link.living_addresses if link is not None else 0


class SerialVehicle:
    """A fake vehicle at the far end of a pseudo terminal, which ``device`` leads to."""

    def __init__(self, system_id: int, device: Path) -> None:
        self.vehicle = FakeVehicle(system_id)
        self._far, self._near = os.openpty()
        os.set_blocking(self._far, False)
        tty.setraw(self._near)
        device.unlink(missing_ok=True)
        device.symlink_to(os.ttyname(self._near))
        asyncio.get_running_loop().add_reader(self._far, self._answer)

    def _answer(self) -> None:
        with contextlib.suppress(BlockingIOError):
            answers = self.vehicle.hear(os.read(self._far, 4096))
            os.write(self._far, answers + self.vehicle.telemetry())

    def speak(self) -> None:
        os.write(self._far, self.vehicle.telemetry())

    def unplug(self) -> None:
        asyncio.get_running_loop().remove_reader(self._far)
        os.close(self._far)
        os.close(self._near)


async def test_a_serial_device_that_vanishes_is_used_again_when_it_comes_back(tmp_path: Path) -> None:
    context, notices = make_context()
    device = tmp_path / "ttyUSB0"
    far_end = SerialVehicle(7, device)
    async with open_mavlink([f"serial://{device}:57600"], context) as fleet:
        far_end.speak()
        await until(lambda: 7 in fleet.vehicles())
        await fleet.vehicles()[7].execute(Land(), context.clock.now_s() + PATIENT_S)
        far_end.unplug()
        await until(lambda: any("lost; reconnecting" in notice.text for notice in notices))
        far_end = SerialVehicle(7, device)
        await until(lambda: any("restored" in notice.text for notice in notices))
        far_end.vehicle.boot_ms += 60_000
        far_end.speak()
        await fleet.vehicles()[7].execute(Land(), context.clock.now_s() + PATIENT_S)
    far_end.unplug()


async def test_a_serial_line_that_does_not_drain_loses_whole_packets(tmp_path: Path) -> None:
    device = tmp_path / "ttyUSB0"
    far, near = os.openpty()
    tty.setraw(near)
    device.symlink_to(os.ttyname(near))
    os.close(near)
    link = parse_link(f"serial://{device}:57600")
    endpoint = SerialEndpoint(0, link, lambda _data, _peer: None)
    endpoint.open()
    packet = FakeVehicle().heartbeat()
    for _ in range(5000):
        endpoint.send(packet, endpoint.peer)
    received = b""
    os.set_blocking(far, False)
    while endpoint._unsent or not received:
        await asyncio.sleep(0.001)
        with contextlib.suppress(BlockingIOError):
            received += os.read(far, 65536)
    endpoint.close()
    os.set_blocking(far, True)
    with contextlib.suppress(OSError):  # the end of what was written: only now is everything known to have come
        while rest := os.read(far, 65536):
            received += rest
    os.close(far)
    assert len(received) % len(packet) == 0
    assert len(received) < 5000 * len(packet)


async def test_a_missing_serial_device_is_named_with_the_remedy(tmp_path: Path) -> None:
    context, _notices = make_context()
    with pytest.raises(LinkError, match="does not exist: connect the radio"):
        await enter([f"serial://{tmp_path / 'ttyUSB7'}:57600"], context)


@pytest.mark.parametrize(("kind", "scheme"), [(socket.SOCK_DGRAM, "udpin"), (socket.SOCK_STREAM, "tcpin")])
async def test_a_taken_port_is_named_with_the_remedy(kind: socket.SocketKind, scheme: str) -> None:
    context, _notices = make_context()
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind((HOST, 0))
        if kind == socket.SOCK_STREAM:
            taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(LinkError, match=f"port {port} is in use: stop the other ground station"):
            await enter([f"{scheme}://{HOST}:{port}"], context)


async def enter(links: list[str], context: DriverContext) -> None:
    async with open_mavlink(links, context):
        pass


async def test_a_connection_that_is_reset_before_it_is_used_ends_like_a_broken_one() -> None:
    with socket.create_server((HOST, 0)) as server, socket.create_connection(server.getsockname()) as ours:
        theirs = server.accept()[0]
        theirs.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        theirs.close()
        ours.setblocking(False)
        await TcpEndpoint(0, _ignore).serve(*await asyncio.open_connection(sock=ours))


async def test_a_connection_over_which_nothing_gets_through_is_given_up() -> None:
    with socket.create_server((HOST, 0)) as server, socket.create_connection(server.getsockname()) as ours:
        copy = ours.dup()
        server.accept()[0].close()
        ours.setblocking(False)
        with copy:
            await TcpEndpoint(0, _ignore).serve(*await asyncio.open_connection(sock=ours))
            assert copy.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 10_000


def _ignore(data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
    """Leave what is received."""


@pytest.mark.parametrize(
    "error", [termios.error(5, "Input/output error"), ValueError("Failed to set custom baud rate")]
)
async def test_whatever_opening_a_serial_device_raises_is_tried_again(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(serial, "Serial", fail)
    with pytest.raises(OSError, match=str(error.args[-1])):
        SerialEndpoint(0, parse_link("serial:///dev/ttyUSB0:57600"), _ignore).open()


async def test_nobody_at_the_other_end_of_tcpout_is_a_link_error() -> None:
    context, _notices = make_context()
    port = unused_port(socket.SOCK_STREAM)
    with pytest.raises(LinkError, match=f"tcpout://{HOST}:{port} cannot be opened"):
        await enter([f"tcpout://{HOST}:{port}"], context)


async def test_no_link_and_an_unwritable_log_folder_are_configuration_errors(tmp_path: Path) -> None:
    context, _notices = make_context()
    with pytest.raises(ConfigurationError, match="at least one link"):
        await enter([], context)
    (tmp_path / "file").write_text("")
    context, _notices = make_context(log_folder=tmp_path / "file")
    with pytest.raises(ConfigurationError, match="choose another log folder"):
        await enter([f"udpin://{HOST}:{unused_port()}"], context)


async def test_errors_of_the_body_come_through_as_they_are() -> None:
    context, _notices = make_context()

    async def body(fleet: Fleet) -> None:
        assert fleet.vehicles() == {}
        raise CommandRefusedError("as it is")

    async def run() -> None:
        async with open_mavlink([f"udpin://{HOST}:{unused_port()}"], context) as fleet:
            await body(fleet)

    with pytest.raises(CommandRefusedError, match="as it is"):
        await run()
