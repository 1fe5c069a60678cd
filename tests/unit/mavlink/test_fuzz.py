"""Everything that parses bytes of the network: whatever arrives, nothing is raised and memory is bounded."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import hypothesis.strategies as st
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress, parse_link
from aos_drivers.mavlink.doctor.diagnosis import Examination, diagnose
from aos_drivers.mavlink.doctor.traffic import Traffic
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.signer import LinkSigner, SigningClock, ticks_of
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fuzz_inputs import use_session

KEY, OTHER_KEY = hashlib.sha256(b"right").digest(), hashlib.sha256(b"wrong").digest()
UTC_S = 1_800_000_000.0
OPEN_LINK, SIGNED_LINK = 0, 1
TALKATIVE = [
    mavlink.MAVLINK_MSG_ID_HEARTBEAT,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    mavlink.MAVLINK_MSG_ID_TIMESYNC,
    mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
    mavlink.MAVLINK_MSG_ID_STATUSTEXT,
    mavlink.MAVLINK_MSG_ID_COMMAND_ACK,
    mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION,
    mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED,
    mavlink.MAVLINK_MSG_ID_RADIO_STATUS,
    mavlink.MAVLINK_MSG_ID_ATTITUDE,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
    mavlink.MAVLINK_MSG_ID_CAMERA_FEEDBACK,
    mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS,
]


@dataclass(frozen=True, slots=True)
class Arrival:
    """Bytes and where they come from, after a pause."""

    data: bytes
    peer: PeerAddress
    pause_s: float


@st.composite
def valid_packets(draw: st.DrawFn) -> bytes:
    message_id = draw(st.sampled_from(TALKATIVE) | st.sampled_from(sorted(mavlink.mavlink_map)))
    kind = mavlink.mavlink_map[message_id]
    encoder = mavlink.MAVLink(
        None, draw(st.just(1) | st.integers(0, 255)), draw(st.sampled_from([0, 1, 100, 190, 255]))
    )
    encoder.seq = draw(st.integers(0, 255))
    key = draw(st.sampled_from([None, KEY, OTHER_KEY]))
    if key is not None:
        encoder.signing.secret_key, encoder.signing.sign_outgoing = key, True
        encoder.signing.timestamp = draw(st.integers(0, 2**48 - 1) | st.just(ticks_of(UTC_S)))
    payload = draw(st.binary(min_size=1, max_size=kind.unpacker.size)).ljust(1, b"\0")
    packet: bytes = mavlink.MAVLink_message(message_id, kind.msgname)._pack(encoder, kind.crc_extra, payload)
    return packet


@st.composite
def damaged_packets(draw: st.DrawFn) -> bytes:
    packet = bytearray(draw(valid_packets()))
    packet[draw(st.integers(0, len(packet) - 1))] = draw(st.integers(0, 255))
    return bytes(packet[: draw(st.integers(0, len(packet)))])


arrivals = st.builds(
    Arrival,
    valid_packets() | damaged_packets() | st.binary(max_size=400),
    st.builds(PeerAddress, st.sampled_from([OPEN_LINK, SIGNED_LINK]), st.just("h"), st.integers(1, 12)),
    st.floats(0.0, 30.0),
)


def signer() -> LinkSigner:
    return LinkSigner(SIGNED_LINK, KEY, SigningClock(lambda: UTC_S, 0), accepts_unsigned=False)


@settings(max_examples=60, deadline=None)
@given(st.lists(arrivals, max_size=25))
def test_whatever_arrives_is_survived(arriving: list[Arrival]) -> None:
    session = MavlinkSession(254, 5.0, {SIGNED_LINK: signer()})
    traffic = Traffic({SIGNED_LINK: signer()})
    now_s = 0.0
    session.feed(FakeVehicle(1).telemetry() + FakeVehicle(1).camera_heartbeat(), PeerAddress(OPEN_LINK, "h", 1), now_s)
    for arrival in arriving:
        now_s += arrival.pause_s
        session.feed(arrival.data, arrival.peer, now_s)
        traffic.feed(arrival.data, arrival.peer, now_s)
        use_session(session, now_s)
    links = [parse_link("udpin://0.0.0.0:14550"), parse_link("udpin://0.0.0.0:14551?sign=a.key")]
    diagnose(Examination(links, 254, traffic, session.records, [], now_s))


@settings(max_examples=60, deadline=None)
@given(st.lists(valid_packets(), min_size=1, max_size=10), st.integers(1, 40))
def test_a_stream_may_be_cut_anywhere(packets: list[bytes], size: int) -> None:
    data, peer = b"".join(packets), PeerAddress(OPEN_LINK, "h", 1)
    whole, pieces = MavlinkSession(254, 5.0), MavlinkSession(254, 5.0)
    whole.feed(data, peer, 0.0)
    for start in range(0, len(data), size):
        pieces.feed(data[start : start + size], peer, 0.0)
    assert list(pieces.records) == list(whole.records)


def test_a_thousand_addresses_that_pretend_to_be_vehicles_shut_nobody_out_for_long() -> None:
    session = MavlinkSession(254, 5.0)
    called = PeerAddress(1, "10.0.0.9", 14550)
    session.add_peer(called)
    for number in range(1200):
        pretender = FakeVehicle(1 + number % 200)
        session.feed(pretender.heartbeat(), PeerAddress(0, "10.9.9.9", number), number * 1e-3)
    assert len(session._peers) == 512
    newcomer = FakeVehicle(240)
    session.feed(newcomer.heartbeat(), PeerAddress(0, "10.0.0.1", 1), 70.0)
    assert 240 in session.records
    assert called in session._peers
    session.send(1, 1, mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    session.poll(70.0)
    assert len(session._peers) == 512
    assert [outgoing.packet for outgoing in session.take_outgoing()], "whoever is spoken to is not forgotten"


def test_one_vehicle_at_many_addresses_is_bounded() -> None:
    session = MavlinkSession(254, 5.0)
    vehicle = FakeVehicle(1)
    for number in range(300):
        vehicle.boot_ms += 10
        peer = PeerAddress(0, "10.9.9.9", number % 100)
        session.feed(vehicle.heartbeat() + vehicle.position(), peer, number * 0.1)
        session.poll(number * 0.1)
    record = session.records[1]
    assert len(record.route._paths) <= 8
    assert len(record.identity._sightings) <= 8
    assert len(record.duplicates._seen) <= 1024
