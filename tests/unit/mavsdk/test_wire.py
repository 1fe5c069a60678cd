"""What stands between the sockets and MAVSDK: each packet to its vehicle alone, no heartbeat but ours."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavsdk.wire import ANY_COMPONENT, Wire
from aos_drivers.vehicle.autopilots.base import Target

NEAR, FAR = PeerAddress(0, "10.0.0.1", 1000), PeerAddress(0, "10.0.0.2", 1000)
CAMERA = mavlink.MAV_COMP_ID_CAMERA


STRANGER = 9
"""System id of a sender whose packets are not passed on."""


def packet(message: mavlink.MAVLink_message, system_id: int, component_id: int = 1) -> bytes:
    return bytes(message.pack(mavlink.MAVLink(None, srcSystem=system_id, srcComponent=component_id)))


def heartbeat() -> mavlink.MAVLink_message:
    return mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4, 0, 0, 3, 3)


def command(system_id: int, component_id: int = 1) -> mavlink.MAVLink_message:
    land = mavlink.MAV_CMD_NAV_LAND
    return mavlink.MAVLink_command_long_message(system_id, component_id, land, 0, 0, 0, 0, 0, 0, 0, 0)


@dataclass
class Radio:
    """An endpoint that keeps what it is given."""

    sent: list[tuple[mavlink.MAVLink_message, PeerAddress]] = field(default_factory=list)

    def send(self, data: bytes, peer: PeerAddress) -> None:
        message = mavlink.MAVLink(None).decode(bytearray(data))
        self.sent.append((message, peer))


@dataclass
class Bench:
    radio: Radio = field(default_factory=Radio)
    delivered: list[bytes] = field(default_factory=list)
    recorded: list[bytes] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.wire = Wire(254, self.delivered.append, self.note, self.recorded.append, lambda _ago_s: 0.0)
        self.wire.add_endpoint(0, self.radio, None)

    def note(self, message: mavlink.MAVLink_message, peer: PeerAddress, _now_s: float) -> bool:
        self.wire.route(message.get_srcSystem(), message.get_srcComponent(), peer)
        return message.get_srcSystem() != STRANGER


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.wire.receive(packet(heartbeat(), 1), NEAR)
    bench.wire.receive(packet(heartbeat(), 2), FAR)
    return bench


def test_mavsdk_gets_whole_packets_whatever_the_link_cuts(bench: Bench) -> None:
    data = packet(heartbeat(), 1)
    bench.delivered.clear()
    for byte in b"noise" + data:
        bench.wire.receive(bytes([byte]), NEAR)
    assert bench.delivered == [data]


def test_mavsdk_gets_nothing_of_senders_that_are_not_admitted(bench: Bench) -> None:
    delivered = len(bench.delivered)
    bench.wire.receive(packet(heartbeat(), STRANGER), FAR)
    assert len(bench.delivered) == delivered
    assert len(bench.recorded) == delivered + 1


def test_a_packet_goes_to_its_vehicle_and_nobody_else(bench: Bench) -> None:
    bench.wire.send(packet(command(2), 254))
    ((message, peer),) = bench.radio.sent
    assert (peer, message.target_system, message.command) == (FAR, 2, mavlink.MAV_CMD_NAV_LAND)


def test_a_vehicle_that_moves_to_another_address_is_followed(bench: Bench) -> None:
    bench.wire.receive(packet(heartbeat(), 2), NEAR)
    bench.wire.send(packet(command(2), 254))
    assert bench.radio.sent[0][1] == NEAR
    assert bench.wire.host_of(2, 1) == "10.0.0.1"


def test_a_camera_at_an_address_of_its_own_is_reached_there(bench: Bench) -> None:
    bench.wire.receive(packet(heartbeat(), 1, CAMERA), FAR)
    bench.wire.send(packet(command(1, CAMERA), 254) + packet(command(1), 254))
    assert [peer for _, peer in bench.radio.sent] == [FAR, NEAR]
    assert bench.wire.host_of(1, CAMERA) == "10.0.0.2"


def test_a_component_that_was_never_heard_is_sought_where_the_autopilot_is(bench: Bench) -> None:
    bench.wire.route(1, ANY_COMPONENT, NEAR)
    bench.wire.send(packet(command(1, CAMERA), 254) + packet(command(2, CAMERA), 254))
    assert [peer for _, peer in bench.radio.sent] == [NEAR]


def test_what_is_for_everybody_or_for_strangers_is_not_sent(bench: Bench) -> None:
    bench.wire.send(packet(command(0), 254) + packet(command(77), 254))
    assert bench.radio.sent == []


def test_only_our_own_heartbeat_leaves_and_reaches_every_vehicle_once(bench: Bench) -> None:
    bench.wire.send(packet(heartbeat(), 254))
    assert bench.radio.sent == []
    bench.wire.send_heartbeat()
    assert {peer for _, peer in bench.radio.sent} == {NEAR, FAR}
    assert all(message.type == mavlink.MAV_TYPE_GCS for message, _ in bench.radio.sent)


def test_every_address_sees_consecutive_sequence_numbers(bench: Bench) -> None:
    for target in (1, 2, 2, 1, 1):
        bench.wire.send(packet(command(target), 254))
    assert [message.get_seq() for message, peer in bench.radio.sent if peer == NEAR] == [0, 1, 2]
    assert [message.get_seq() for message, peer in bench.radio.sent if peer == FAR] == [0, 1]


def test_both_directions_are_recorded(bench: Bench) -> None:
    bench.wire.send(packet(command(1), 254))
    assert len(bench.recorded) == 3


def test_strangers_beyond_the_limit_are_not_kept() -> None:
    bench = Bench()
    for number in range(600):
        bench.wire.receive(packet(heartbeat(), 1), PeerAddress(0, "10.0.0.9", number))
    assert len(bench.delivered) == 512


def test_what_names_no_target_goes_to_one_vehicle_alone(bench: Bench) -> None:
    bench.wire.receive(packet(heartbeat(), 2), FAR)
    bench.wire.send_to(Target(2, 1), mavlink.MAVLink_timesync_message(0, 5))
    bench.wire.send_to(Target(3, 1), mavlink.MAVLink_timesync_message(0, 6))
    assert [(message.ts1, peer) for message, peer in bench.radio.sent] == [(5, FAR)]
