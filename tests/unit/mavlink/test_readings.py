"""Readings of a link: several datagrams that the driver takes in together."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import pytest

from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.settings import CameraPlan
from aos_drivers.links.address import PeerAddress
from aos_drivers.links.recorder import TlogRecorder
from aos_drivers.mavlink.service import MavlinkFleet
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.vehicle.cameras.exposure import CaptureTools
from aos_gcs.clock import LoopClock
from aos_gcs.ports import DriverContext
from tests.fakes.mavlink_vehicle import FakeVehicle

_STAMP_BYTES = 8
A, B = PeerAddress(0, "10.0.0.1", 5001), PeerAddress(0, "10.0.0.2", 5002)


class Wire:
    """An endpoint that keeps what is sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[bytes, PeerAddress]] = []

    def send(self, data: bytes, peer: PeerAddress) -> None:
        self.sent.append((data, peer))


def new_fleet(recorder: TlogRecorder | None) -> tuple[MavlinkFleet, MavlinkSession, Wire]:
    clock, wire = LoopClock(), Wire()
    context = DriverContext(clock, lambda: True, lambda _notice: None)
    session = MavlinkSession(254, 5.0)
    tools = CaptureTools(clock, cast("ImageFetcher", None), CameraPlan(), context.notify, lambda _work: None)
    fleet = MavlinkFleet(session, context, tools, recorder)
    fleet.add_endpoint(0, wire, None)
    return fleet, session, wire


@pytest.mark.looptime
async def test_a_reading_is_recorded_in_order_and_its_vehicles_exist_when_it_ends(tmp_path: Path) -> None:
    recorder = TlogRecorder(tmp_path / "a.tlog", pytest.fail)
    fleet, session, _wire = new_fleet(recorder)
    first, second = FakeVehicle(1), FakeVehicle(2)
    packets = [first.heartbeat(), second.heartbeat(), first.position()]
    for packet, peer in zip(packets, (A, B, A), strict=True):
        fleet.take(packet, peer)
    assert not fleet.vehicles()
    fleet.settle()
    assert sorted(fleet.vehicles()) == [1, 2]
    assert session.take_events() == []
    recorder.close()
    data = (tmp_path / "a.tlog").read_bytes()
    for packet in packets:
        assert data[_STAMP_BYTES:].startswith(packet)
        data = data[_STAMP_BYTES + len(packet) :]
    assert not data


@pytest.mark.looptime
async def test_each_datagram_of_a_reading_counts_from_its_own_arrival() -> None:
    fleet, session, _wire = new_fleet(None)
    vehicle = FakeVehicle()
    fleet.receive(vehicle.heartbeat(), A)
    vehicle.boot_ms += 100
    for waited_s in (0.015, 0.005):
        vehicle.boot_ms += 10
        fleet.take(vehicle.position(), A, waited_s)
    fleet.settle()
    state = session.records[1].state(0.0)
    assert state.position_at_s == pytest.approx(-0.005)
    assert session.records[1].heard_at_s == pytest.approx(0.0)


@pytest.mark.looptime
async def test_answers_to_a_reading_are_sent_when_it_ends() -> None:
    fleet, session, wire = new_fleet(None)
    vehicle = FakeVehicle()
    fleet.receive(vehicle.heartbeat(), A)
    session.poll(0.0)  # requests the first stream
    session.take_outgoing()
    fleet.take(vehicle.ack(511, 0), A)
    assert not wire.sent
    fleet.settle()
    assert [peer for _packet, peer in wire.sent] == [A]


async def test_an_error_in_one_datagram_does_not_fix_the_time_of_later_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    fleet, session, _wire = new_fleet(None)

    def fail(*_: object) -> None:
        raise ZeroDivisionError("of a test")

    monkeypatch.setattr(session, "take", fail)
    with pytest.raises(ZeroDivisionError):
        fleet.receive(b"x", A)
    assert fleet._read_at_s is None
