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
from aos_drivers.mavlink.doctor.diagnosis import Examination, Finding, Level, diagnose
from aos_drivers.mavlink.doctor.survey import Survey
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
) -> list[Finding]:
    signers = {
        number: LinkSigner(number, KEY, SigningClock(lambda: UTC_S, 0), link.signing.accepts_unsigned)
        for number, link in enumerate(links)
        if link.signing is not None
    }
    session = MavlinkSession(254, 5.0, signers)
    survey = Survey({link: signer.with_empty_memory() for link, signer in signers.items()})
    for tick in range(120):
        now_s = tick / 10
        if tick == 60:
            survey.start_rates(now_s)
        arriving = [(peer, speak(tick)) for peer, speak in speakers.items()]
        session.poll(now_s)
        for outgoing in session.take_outgoing():
            if vehicles is not None and outgoing.peer in vehicles:
                arriving.append((outgoing.peer, answers_of(vehicles[outgoing.peer], outgoing.packet)))
        for peer, data in arriving:
            if data:
                survey.feed(data, peer, now_s)
                session.feed(data, peer, now_s)
    return diagnose(Examination(links, 254, survey, session.records, elsewhere, 12.0))


def problems(findings: Sequence[Finding]) -> list[str]:
    return [finding.code for finding in findings if finding.level is Level.PROBLEM]


def text_of(findings: Sequence[Finding], code: str) -> str:
    return next(finding.text for finding in findings if finding.code == code)


def test_a_healthy_vehicle_is_described() -> None:
    vehicle = FakeVehicle(1)
    findings = examine({A: healthy(vehicle)}, {A: vehicle})
    assert [(finding.level, finding.code, finding.system_id) for finding in findings] == [(Level.OK, "vehicle", 1)]
    assert findings[0].text == "vehicle 1 (arducopter) at 10.0.0.1:5001: positions at 5.0 Hz"


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
    findings = examine({}, links=[parse_link(link)])
    assert problems(findings) == ["no_packets"]
    assert f"nothing arrives on {link}" in findings[0].text
    assert words in findings[0].text


def test_packets_at_another_port_are_a_wrong_port() -> None:
    findings = examine({}, elsewhere=[14540])
    assert problems(findings) == ["no_packets", "wrong_port"]
    assert "port 14540 of this computer instead" in text_of(findings, "wrong_port")


def test_noise_on_a_serial_line_is_a_wrong_baud_rate() -> None:
    findings = examine({A: lambda _tick: b"\x00\xf8\x80"}, links=[parse_link("serial:///dev/ttyUSB0:57600")])
    assert problems(findings) == ["no_mavlink"]
    assert "baud rate is probably wrong: 57600" in findings[0].text


def test_other_ground_stations_are_named_and_one_with_our_id_is_a_problem() -> None:
    vehicle = FakeVehicle(1)
    speakers = {A: healthy(vehicle), B: ground_station(255)}
    findings = examine(speakers, {A: vehicle})
    assert (problems(findings), findings[0].code) == ([], "other_ground_station")
    assert problems(examine({**speakers, B: ground_station(254)}, {A: vehicle})) == ["ground_station_clash"]
    assert problems(examine({B: ground_station(255)})) == ["no_vehicle"]


def test_one_id_at_two_addresses_is_a_problem_unless_the_board_is_the_same() -> None:
    for uid, codes in ((1001, []), (2002, ["duplicate_id"])):
        first, second = FakeVehicle(1), FakeVehicle(1)
        second.uid = uid
        second.encoder.skip(100)
        findings = examine({A: healthy(first), B: healthy(second)}, {A: first, B: second})
        assert problems(findings) == codes
        text = text_of(findings, codes[0] if codes else "several_links")
        assert "10.0.0.1:5001 and 10.0.0.2:5002" in text
        assert ("(the boards differ)" in text) == bool(codes)


def test_slow_streams_are_named_with_both_rates() -> None:
    vehicle = FakeVehicle(1)

    def slow(tick: int) -> bytes:
        return healthy(vehicle)(tick) if tick % 10 == 0 else b""

    findings = examine({A: slow}, {A: vehicle})
    assert set(problems(findings)) == {"slow_stream"}
    assert "sends GLOBAL_POSITION_INT at 1.0 Hz; a mission asks for 5 Hz" in findings[0].text


def test_losses_and_silence_are_problems() -> None:
    lossy, leaving = FakeVehicle(1), FakeVehicle(2)

    def lose(tick: int) -> bytes:
        lossy.encoder.skip(1)
        return healthy(lossy)(tick)

    def leave(tick: int) -> bytes:
        return healthy(leaving)(tick) if tick < 50 else b""

    findings = examine({A: lose, B: leave}, {A: lossy})
    assert problems(findings) == ["loss", "silent"]


def test_mavlink_1_is_told_with_the_parameter_to_set() -> None:
    encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    heartbeat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, 3, 0, 0, 3, 3)
    findings = examine({A: lambda tick: heartbeat.pack(encoder, force_mavlink1=True) if tick % 10 == 0 else b""})
    assert "mavlink_1" in problems(findings)
    assert "SERIALn_PROTOCOL" in text_of(findings, "mavlink_1")


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
    findings = examine({A: healthy(vehicle)}, {A: vehicle}, links=[link])
    assert problems(findings) == ([code] if code else [])


def test_old_signatures_are_a_matter_of_the_clock() -> None:
    vehicle = FakeVehicle(1)
    vehicle.encoder.sign(KEY, UTC_S - 86_400.0)
    findings = examine({A: healthy(vehicle)}, links=[SIGNED])
    assert problems(findings) == ["late_signatures"]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([A, B]), st.binary(max_size=300)), max_size=10))
def test_any_bytes_lead_to_a_diagnosis(chunks: list[tuple[PeerAddress, bytes]]) -> None:
    survey, session = Survey({}), MavlinkSession(254, 5.0)
    for number, (peer, data) in enumerate([(A, FakeVehicle(1).telemetry()), *chunks]):
        survey.feed(data, peer, float(number))
        session.feed(data, peer, float(number))
    assert diagnose(Examination([UDP], 254, survey, session.records, [], 20.0))


def test_what_is_counted_is_bounded() -> None:
    survey = Survey({})
    for port in range(700):
        survey.feed(Encoder(1 + port % 250, 1 + port // 250).pack(HEARTBEAT), PeerAddress(0, "h", port), 0.0)
    assert len(survey.senders) == len(survey._parsers) == 512
    for number in range(2500):
        survey.feed(Encoder(1 + number % 250, 1 + number // 250).pack(HEARTBEAT), PeerAddress(0, "h", 1), 0.0)
    assert len(survey.senders) == 2048
