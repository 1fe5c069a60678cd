"""What the doctor says about links that are ill in one way each."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import LinkAddress, PeerAddress, SigningOptions, parse_link
from aos_drivers.mavlink.doctor.diagnosis import Diagnosis, Examination, Level, diagnose
from aos_drivers.mavlink.doctor.traffic import Traffic
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.signer import LinkSigner, SigningClock
from tests.fakes.mavlink_vehicle import Encoder, FakeVehicle

A, B = PeerAddress(0, "10.0.0.1", 5001), PeerAddress(0, "10.0.0.2", 5002)
UDP = parse_link("udpin://0.0.0.0:14550")
KEY, OTHER_KEY = hashlib.sha256(b"right").digest(), hashlib.sha256(b"wrong").digest()
UTC_S = 1_800_000_000.0
HEARTBEAT = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, 3, 0, 0, 3, 3)
SIGNED = LinkAddress("udpin", "0.0.0.0", 14550, "udpin://0.0.0.0:14550?sign=a.key", SigningOptions(Path("a.key")))  # noqa: S104

Speaker = Callable[[int], bytes]
"""What somebody sends in a tick of a tenth of a second."""


def healthy(vehicle: FakeVehicle) -> Speaker:
    """Everything that a mission asks for."""

    def speak(tick: int) -> bytes:
        vehicle.boot_ms += 100
        rarely = vehicle.heartbeat() + vehicle.sys_status() + vehicle.gps() if tick % 10 == 0 else b""
        return rarely + (vehicle.position() + vehicle.extended_state() if tick % 2 == 0 else b"")

    return speak


def ground_station(system_id: int) -> Speaker:
    encoder = Encoder(system_id, 190)
    heartbeat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3)
    return lambda tick: encoder.pack(heartbeat) if tick % 10 == 0 else b""


def answers_of(vehicle: FakeVehicle, packet: bytes) -> bytes:
    asked = len(vehicle.sent(mavlink.MAV_CMD_REQUEST_MESSAGE))
    answer = vehicle.hear(packet)
    requests = vehicle.sent(mavlink.MAV_CMD_REQUEST_MESSAGE)[asked:]
    is_asked = any(request.param1 == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION for request in requests)
    return answer + (vehicle.version() if is_asked else b"")


def examine(
    speakers: dict[PeerAddress, Speaker],
    vehicles: dict[PeerAddress, FakeVehicle] | None = None,
    *,
    links: Sequence[LinkAddress] = (UDP,),
    elsewhere: Sequence[int] = (),
) -> list[Diagnosis]:
    signers = {
        number: LinkSigner(number, KEY, SigningClock(lambda: UTC_S, 0), link.signing.accepts_unsigned)
        for number, link in enumerate(links)
        if link.signing is not None
    }
    session = MavlinkSession(254, 5.0, signers)
    traffic = Traffic({link: signer.with_empty_memory() for link, signer in signers.items()})
    for tick in range(120):
        now_s = tick / 10
        if tick == 60:
            traffic.start_rates(now_s)
        arriving = [(peer, speak(tick)) for peer, speak in speakers.items()]
        session.poll(now_s)
        for outgoing in session.take_outgoing():
            if vehicles is not None and outgoing.peer in vehicles:
                arriving.append((outgoing.peer, answers_of(vehicles[outgoing.peer], outgoing.packet)))
        for peer, data in arriving:
            if data:
                traffic.feed(data, peer, now_s)
                session.feed(data, peer, now_s)
    return diagnose(Examination(links, 254, traffic, session.records, elsewhere, 12.0))


def problems(diagnoses: Sequence[Diagnosis]) -> list[str]:
    return [diagnosis.code for diagnosis in diagnoses if diagnosis.level is Level.PROBLEM]


def text_of(diagnoses: Sequence[Diagnosis], code: str) -> str:
    return next(diagnosis.text for diagnosis in diagnoses if diagnosis.code == code)


def test_a_healthy_vehicle_is_described() -> None:
    vehicle = FakeVehicle(1)
    diagnoses = examine({A: healthy(vehicle)}, {A: vehicle})
    assert [(diagnosis.level, diagnosis.code, diagnosis.system_id) for diagnosis in diagnoses] == [
        (Level.OK, "vehicle", 1)
    ]
    assert diagnoses[0].text == "vehicle 1 (arducopter) at 10.0.0.1:5001: positions at 5.0 Hz"


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ("udpin://0.0.0.0:14550", "firewall"),
        ("udpout://10.0.0.5:14550", "ping"),
        ("tcpout://10.0.0.5:5760", "MAVLink port"),
        ("tcpin://0.0.0.0:5760", "no connection yet"),
        ("serial:///dev/ttyUSB0:57600", "cable"),
    ],
)
def test_silence_names_what_to_check(link: str, words: str) -> None:
    diagnoses = examine({}, links=[parse_link(link)])
    assert problems(diagnoses) == ["no_packets"]
    assert f"nothing arrives on {link}" in diagnoses[0].text
    assert words in diagnoses[0].text


def test_packets_at_another_port_are_a_wrong_port() -> None:
    diagnoses = examine({}, elsewhere=[14540])
    assert problems(diagnoses) == ["no_packets", "wrong_port"]
    assert "port 14540 of this computer instead" in text_of(diagnoses, "wrong_port")


def test_noise_on_a_serial_line_is_a_wrong_baud_rate() -> None:
    diagnoses = examine({A: lambda _tick: b"\x00\xf8\x80"}, links=[parse_link("serial:///dev/ttyUSB0:57600")])
    assert problems(diagnoses) == ["no_mavlink"]
    assert "baud rate is probably wrong: 57600" in diagnoses[0].text


def test_other_ground_stations_are_named_and_one_with_our_id_is_a_problem() -> None:
    vehicle = FakeVehicle(1)
    speakers = {A: healthy(vehicle), B: ground_station(255)}
    diagnoses = examine(speakers, {A: vehicle})
    assert (problems(diagnoses), diagnoses[0].code) == ([], "other_ground_station")
    assert problems(examine({**speakers, B: ground_station(254)}, {A: vehicle})) == ["ground_station_clash"]
    assert problems(examine({B: ground_station(255)})) == ["no_vehicle"]


def test_one_id_at_two_addresses_is_a_problem_unless_the_board_is_the_same() -> None:
    for uid, codes in ((1001, []), (2002, ["duplicate_id"])):
        first, second = FakeVehicle(1), FakeVehicle(1)
        second.uid = uid
        second.encoder.skip(100)
        diagnoses = examine({A: healthy(first), B: healthy(second)}, {A: first, B: second})
        assert problems(diagnoses) == codes
        text = text_of(diagnoses, codes[0] if codes else "several_links")
        assert "10.0.0.1:5001 and 10.0.0.2:5002" in text
        assert ("(the boards differ)" in text) == bool(codes)


def test_slow_streams_are_named_with_both_rates() -> None:
    vehicle = FakeVehicle(1)

    def slow(tick: int) -> bytes:
        return healthy(vehicle)(tick) if tick % 10 == 0 else b""

    diagnoses = examine({A: slow}, {A: vehicle})
    assert set(problems(diagnoses)) == {"slow_stream"}
    assert "sends GLOBAL_POSITION_INT at 1.0 Hz; a mission asks for 5 Hz" in diagnoses[0].text


def test_losses_and_silence_are_problems() -> None:
    lossy, leaving = FakeVehicle(1), FakeVehicle(2)

    def lose(tick: int) -> bytes:
        lossy.encoder.skip(1)
        return healthy(lossy)(tick)

    def leave(tick: int) -> bytes:
        return healthy(leaving)(tick) if tick < 50 else b""

    diagnoses = examine({A: lose, B: leave}, {A: lossy})
    assert problems(diagnoses) == ["loss", "silent"]


def test_mavlink_1_is_told_with_the_parameter_to_set() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    heartbeat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, 3, 0, 0, 3, 3)
    diagnoses = examine({A: lambda tick: heartbeat.pack(encoder, force_mavlink1=True) if tick % 10 == 0 else b""})
    assert "mavlink_1" in problems(diagnoses)
    assert "SERIALn_PROTOCOL" in text_of(diagnoses, "mavlink_1")


@pytest.mark.parametrize(
    ("key", "link", "code"),
    [
        (KEY, SIGNED, None),
        (OTHER_KEY, SIGNED, "wrong_key"),
        (None, SIGNED, "unsigned"),
        (KEY, UDP, "key_missing"),
        (None, UDP, None),
    ],
)
def test_signatures_that_do_not_fit_are_told(key: bytes | None, link: LinkAddress, code: str | None) -> None:
    vehicle = FakeVehicle(1)
    if key is not None:
        vehicle.encoder.sign(key, UTC_S)
    diagnoses = examine({A: healthy(vehicle)}, {A: vehicle}, links=[link])
    assert problems(diagnoses) == ([code] if code else [])


def test_old_signatures_are_a_matter_of_the_clock() -> None:
    vehicle = FakeVehicle(1)
    vehicle.encoder.sign(KEY, UTC_S - 86_400.0)
    diagnoses = examine({A: healthy(vehicle)}, links=[SIGNED])
    assert problems(diagnoses) == ["late_signatures"]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([A, B]), st.binary(max_size=300)), max_size=10))
def test_any_bytes_lead_to_a_diagnosis(chunks: list[tuple[PeerAddress, bytes]]) -> None:
    traffic, session = Traffic({}), MavlinkSession(254, 5.0)
    for number, (peer, data) in enumerate([(A, FakeVehicle(1).telemetry()), *chunks]):
        traffic.feed(data, peer, float(number))
        session.feed(data, peer, float(number))
    assert diagnose(Examination([UDP], 254, traffic, session.records, [], 20.0))


def test_what_is_counted_is_bounded() -> None:
    traffic = Traffic({})
    for port in range(700):
        traffic.feed(Encoder(1 + port % 250, 1 + port // 250).pack(HEARTBEAT), PeerAddress(0, "h", port), 0.0)
    assert len(traffic.senders) == len(traffic._parsers) == 512
    for number in range(2500):
        traffic.feed(Encoder(1 + number % 250, 1 + number // 250).pack(HEARTBEAT), PeerAddress(0, "h", 1), 0.0)
    assert len(traffic.senders) == 2048
