"""Limits of what is read from the links: floods against a session without sockets."""

from __future__ import annotations

import random
import socket
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.links.intake import Intake, PeerIntake
from aos_drivers.links.overload import OverloadWatch, dropped_datagrams, drops_in, inode_of
from aos_drivers.mavlink.session import MavlinkSession
from tests.fakes.mavlink_vehicle import FakeVehicle

VEHICLE = PeerAddress(0, "10.0.0.1", 5001)
ATTACKERS = [PeerAddress(0, "10.6.6.6", port) for port in range(10)]


@pytest.fixture
def read_bytes(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Bytes that reach a parser."""
    sizes: list[int] = []
    feed = FrameParser.feed

    def counted(parser: FrameParser, data: bytes) -> list[mavlink.MAVLink_message]:
        sizes.append(len(data))
        return feed(parser, data)

    monkeypatch.setattr(FrameParser, "feed", counted)
    return sizes


def flooded(session: MavlinkSession, vehicle: FakeVehicle, flood: Callable[[], bytes], from_s: float) -> None:
    """Hear the vehicle five times a second for 4 s, and 100 datagrams of each attacker in between."""
    for tick in range(20):
        now_s = from_s + tick / 5
        vehicle.boot_ms += 200
        session.feed(vehicle.heartbeat() + vehicle.position(), VEHICLE, now_s)
        for peer in ATTACKERS:
            for _ in range(10):
                session.feed(flood(), peer, now_s)
        session.poll(now_s)
        session.take_outgoing()


@pytest.mark.parametrize("noise", ["markers", "random", "headers"])
def test_little_of_a_flood_is_parsed_and_vehicles_are_heard(noise: str, read_bytes: list[int]) -> None:
    floods = {
        "markers": b"\xfe" * 1400,
        "random": random.Random(1).randbytes(1400),
        "headers": b"\xfd\x09\x00\x00\x00\x01\x01\x00\x00\x00" * 140,
    }
    session, vehicle = MavlinkSession(254, 5.0), FakeVehicle()
    flooded(session, vehicle, lambda: floods[noise], 0.0)
    record = session.records[1]
    assert record.heard_at_s == pytest.approx(3.8)
    assert record.loss_fraction() == 0.0
    assert sum(read_bytes) < len(ATTACKERS) * (8192 + 4 * 2048 + 2 * 1400) + 4000


def test_a_flood_of_valid_packets_does_not_shut_out_a_vehicle_in_flight(read_bytes: list[int]) -> None:
    session, vehicle, forger = MavlinkSession(254, 5.0), FakeVehicle(), FakeVehicle(77)
    vehicle.armed = True
    session.feed(vehicle.heartbeat() + vehicle.position(), VEHICLE, 0.0)
    session.feed(vehicle.heartbeat(), VEHICLE, 0.1)
    session.poll(0.1)
    flood = b"".join(forger.position() for _ in range(30))
    for tick in range(200):
        for peer in ATTACKERS:
            session.feed(flood, peer, 0.2 + tick / 100)
    vehicle.boot_ms += 2000
    session.feed(vehicle.heartbeat(), VEHICLE, 2.2)
    assert session.records[1].heard_at_s == 2.2
    assert sum(read_bytes) < 200 * len(ATTACKERS) * len(flood) - 500_000


def test_a_noisy_line_that_also_brings_packets_is_read() -> None:
    budget = PeerIntake()
    for tick in range(1000):
        assert budget.settle(tick / 10)
        budget.book(2000, 900)


def test_ever_new_addresses_are_admitted_slowly() -> None:
    intake = Intake()
    admitted = sum(intake.admits(PeerAddress(0, "10.6.6.6", port), None, 1.0) for port in range(5000))
    assert admitted <= 1024
    assert not intake.admits(VEHICLE, None, 1.001)
    assert intake.admits(VEHICLE, None, 2.0)


def test_an_overload_is_reported_as_the_stations_at_most_once_a_minute() -> None:
    counts, told = iter([0, 5, 305, 700, 701, 5000]), []
    watch = OverloadWatch("udpin://0.0.0.0:14550", lambda: next(counts), told.append)
    for now_s in (5.0, 10.0, 15.0, 20.0, 80.0):
        watch.look(now_s)
    assert [text.split(" at ")[0] for text in told] == [
        "this station is overloaded: it lost 300 packets",
        "this station is overloaded: it lost 4299 packets",
    ]


def test_drops_are_read_from_the_table_of_the_system() -> None:
    head = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref"
    row = "  511: 0100007F:5FE6 00000000:0000 07 00000000:00000000 00:00000000 00000000  0 0 424242 2 000000005b1 77"
    assert drops_in(f"{head}\n{row}\n", 424242) == 77
    assert drops_in(f"{head}\n{row}\n", 1) is None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp_socket:
        udp_socket.bind(("127.0.0.1", 0))
        inode = inode_of(udp_socket.fileno())
        assert inode is not None
        assert dropped_datagrams(inode) in (0, None)


def test_the_checksum_is_that_of_mavlink() -> None:
    """What pymavlink packs is found, and every change of it is not."""
    vehicle = FakeVehicle()
    for packet in (vehicle.position(), vehicle.home(), vehicle.status_text("wind")):
        assert len(FrameParser().feed(packet)) == 1
        for index in range(1, len(packet)):
            changed = bytearray(packet)
            changed[index] ^= 0x10
            assert all(
                isinstance(message, mavlink.MAVLink_unknown) for message in FrameParser().feed(bytes(changed))
            ), index
