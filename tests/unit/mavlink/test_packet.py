from __future__ import annotations

import math
import random
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.boot_time import BOOT_TIMED_IDS, boot_ms_of
from aos_drivers.links.framing import FrameParser
from aos_drivers.links.packet import LazyMessage
from tests.fakes.mavlink_vehicle import FakeVehicle

KEY = bytes(range(32))


def packed(kind: type[mavlink.MAVLink_message], payload: bytes, encoder: mavlink.MAVLink, *, v1: bool = False) -> bytes:
    message = kind.__new__(kind)
    mavlink.MAVLink_message.__init__(message, kind.id, kind.msgname)
    return bytes(message._pack(encoder, kind.crc_extra, payload, force_mavlink1=v1))


def comparable(value: Any) -> Any:
    """Return a value in which not-a-number equals itself."""
    if isinstance(value, list):
        return [comparable(each) for each in value]
    return "nan" if isinstance(value, float) and math.isnan(value) else value


def contents(message: mavlink.MAVLink_message) -> dict[str, Any]:
    header = message.get_header()
    return {
        **{name: comparable(value) for name, value in message.to_dict().items()},
        "header": vars(header),
        "own": (message.get_msgId(), message.get_srcSystem(), message.get_srcComponent(), message.get_seq()),
        "crc": message.get_crc(),
        "packet": bytes(message.get_msgbuf()),
    }


@pytest.mark.parametrize("signed", [False, True])
def test_every_kind_of_message_reads_as_pymavlink_reads_it(signed: bool) -> None:
    draw = random.Random(1)
    encoder = mavlink.MAVLink(None, srcSystem=7, srcComponent=31)
    if signed:
        encoder.signing.secret_key, encoder.signing.sign_outgoing = KEY, True
    for kind in mavlink.mavlink_map.values():
        for size in (1, kind.unpacker.size // 2 + 1, kind.unpacker.size, min(255, kind.unpacker.size + 9)):
            encoder.seq = draw.randrange(256)
            packet = packed(kind, draw.randbytes(size), encoder)
            (message,) = FrameParser().feed(packet)
            assert contents(message) == contents(mavlink.MAVLink(None).decode(bytearray(packet)))


def test_mavlink_1_reads_as_pymavlink_reads_it() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=7, srcComponent=31)
    for number in range(256):
        kind = mavlink.mavlink_map.get(number)
        if kind is not None:
            packet = packed(kind, random.Random(number).randbytes(kind.unpacker.size), encoder, v1=True)
            (message,) = FrameParser().feed(packet)
            assert contents(message) == contents(mavlink.MAVLink(None).decode(bytearray(packet)))


def test_a_message_is_decoded_only_when_it_is_read() -> None:
    (message,) = FrameParser().feed(FakeVehicle(3).position())
    assert (message.get_srcSystem(), message.get_type()) == (3, "GLOBAL_POSITION_INT")
    assert "lat" not in vars(message)
    assert message.lat == message.to_dict()["lat"]
    assert "lat" in vars(message)


def test_the_time_since_boot_is_read_without_decoding() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=7, srcComponent=1)
    for message_id in BOOT_TIMED_IDS:
        kind = mavlink.mavlink_map[message_id]
        for start, v1 in ((b"\x01\x02\x03\x84", False), (b"\x01\x02\x00\x00", False), (b"", False), (b"\xff", True)):
            content = start if start and start[-1] else start.rstrip(b"\0") or b"\0"
            packet = packed(kind, content.ljust(kind.unpacker.size, b"\0") if v1 else content, encoder, v1=v1)
            (message,) = FrameParser().feed(packet)
            boot_ms = boot_ms_of(message)
            assert "time_boot_ms" not in vars(message)
            assert boot_ms == message.time_boot_ms == int.from_bytes(start, "little")


def test_a_field_named_like_an_attribute_of_all_messages_is_read() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    (message,) = FrameParser().feed(mavlink.MAVLink_collision_message(0, 42, 0, 0, 0.0, 0.0, 0.0).pack(encoder))
    assert isinstance(message, LazyMessage)
    assert message.id == 42


def test_what_is_no_field_is_missing_and_messages_can_be_packed_again() -> None:
    (message,) = FrameParser().feed(FakeVehicle(3).position())
    assert getattr(message, "target_system", 0) == 0
    message.alt += 1000
    packet = message.pack(mavlink.MAVLink(None, srcSystem=9, srcComponent=1))
    (again,) = FrameParser().feed(packet)
    assert (again.get_srcSystem(), again.alt) == (9, message.alt)
