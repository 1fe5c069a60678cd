from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.framing import FrameParser
from aos_drivers.links.loss import LossCounter
from tests.fakes.mavlink_vehicle import FakeVehicle


def test_a_packet_arrives_in_any_chunking() -> None:
    packet = FakeVehicle().heartbeat() + FakeVehicle().home()
    for size in (1, 2, 7, 12, 500):
        parser = FrameParser()
        messages = [message for i in range(0, len(packet), size) for message in parser.feed(packet[i : i + size])]
        assert [message.get_type() for message in messages] == ["HEARTBEAT", "HOME_POSITION"]
        assert parser.dropped_bytes == 0


def test_noise_that_looks_like_a_long_packet_takes_no_good_one_with_it() -> None:
    vehicle = FakeVehicle()
    noise = b"\xfd\x20\x00garbage"
    data = noise + b"".join(vehicle.heartbeat() for _ in range(4))
    parser = FrameParser()
    assert len(parser.feed(data)) == 4
    assert parser.dropped_bytes == len(noise)


def test_a_damaged_packet_is_dropped_and_counted() -> None:
    vehicle = FakeVehicle()
    damaged = bytearray(vehicle.home())
    damaged[20] ^= 0xFF
    parser = FrameParser()
    messages = parser.feed(bytes(damaged) + vehicle.heartbeat() + vehicle.heartbeat())
    assert [message.get_type() for message in messages] == ["HEARTBEAT", "HEARTBEAT"]
    assert parser.dropped_bytes == len(damaged)


def test_packets_with_unknown_incompatible_features_are_dropped() -> None:
    packet = bytearray(FakeVehicle().heartbeat())
    packet[2] = 0x40
    parser = FrameParser()
    assert parser.feed(bytes(packet)) == []
    assert parser.dropped_bytes == len(packet)


def test_mavlink_1_is_understood() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=3, srcComponent=1)
    packet = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3).pack(encoder, force_mavlink1=True)
    assert [message.get_srcSystem() for message in FrameParser().feed(packet)] == [3]


@settings(max_examples=150, deadline=None)
@given(st.lists(st.binary(max_size=300), max_size=8))
def test_random_bytes_never_raise_and_little_is_kept(chunks: list[bytes]) -> None:
    parser = FrameParser()
    for chunk in chunks:
        parser.feed(chunk)
    assert len(parser._tail) <= 10 + 255 + 2 + 13


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=60).filter(lambda noise: b"\xfd" not in noise and b"\xfe" not in noise))
def test_packets_between_noise_are_all_found(noise: bytes) -> None:
    vehicle = FakeVehicle()
    parser = FrameParser()
    data = noise + vehicle.heartbeat() + noise + vehicle.position() + noise
    assert len(parser.feed(data)) == 2
    assert parser.dropped_bytes == 3 * len(noise)


def test_loss_is_the_share_of_missing_sequence_numbers() -> None:
    counter = LossCounter()
    for number in range(250, 250 + 400):
        if number % 4:
            counter.count(number % 256)
    assert counter.lost / (counter.lost + counter.received) == pytest.approx(0.25, abs=0.01)


def test_late_and_repeated_packets_are_no_loss() -> None:
    counter = LossCounter()
    for number in (1, 2, 4, 3, 5, 5, 6):
        counter.count(number)
    assert counter.lost == 0
