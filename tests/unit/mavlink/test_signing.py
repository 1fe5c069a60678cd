"""Signing against pymavlink's own implementation, which verifies what we sign and signs what we verify."""

from __future__ import annotations

import hashlib
import itertools
import shutil
from collections.abc import Callable
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress, parse_link
from aos_drivers.links.framing import FrameParser
from aos_drivers.mavlink.session import Event, MavlinkSession
from aos_drivers.mavlink.signing.key_file import read_key, read_ticks, time_file_of, write_ticks
from aos_drivers.mavlink.signing.keyring import Keyring
from aos_drivers.mavlink.signing.signer import TICKS_PER_S, LinkSigner, SignatureCheck, SigningClock, ticks_of
from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import Notice

KEY, OTHER_KEY = hashlib.sha256(b"right").digest(), hashlib.sha256(b"wrong").digest()
A = PeerAddress(0, "10.0.0.1", 5001)
UTC_S = 1_800_000_000.0
HEARTBEAT = (mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, 3, 3)


def foreign(key: bytes | None = KEY, utc_s: float = UTC_S, system_id: int = 1) -> mavlink.MAVLink:
    """Return pymavlink's end of the link."""
    end = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=1)
    if key is not None:
        end.signing.secret_key, end.signing.sign_outgoing = key, True
        end.signing.timestamp = ticks_of(utc_s)
    return end


def pack(end: mavlink.MAVLink, message: mavlink.MAVLink_message | None = None) -> bytes:
    packet: bytes = (message or mavlink.MAVLink_heartbeat_message(*HEARTBEAT)).pack(end)
    end.seq = (end.seq + 1) % 256
    return packet


def signer(*, accepts_unsigned: bool = False, utc_s: Callable[[], float] = lambda: UTC_S) -> LinkSigner:
    return LinkSigner(0, KEY, SigningClock(utc_s, 0), accepts_unsigned)


def texts(events: list[Event]) -> list[str]:
    return [event.text for event in events if isinstance(event, Notice)]


def test_what_pymavlink_signs_is_accepted_and_what_we_sign_pymavlink_accepts() -> None:
    session = MavlinkSession(254, 5.0, {0: signer()})
    vehicle = foreign()
    session.feed(pack(vehicle), A, 0.0)
    assert list(session.records) == [1]
    for now_s in (0.0, 1.0, 2.0):
        session.poll(now_s)
        session.send_heartbeat(now_s)
        for outgoing in session.take_outgoing():
            assert vehicle.decode(bytearray(outgoing.packet)).get_signed()
    assert (vehicle.signing.badsig_count, vehicle.signing.goodsig_count) == (0, vehicle.signing.sig_count)
    assert vehicle.signing.goodsig_count > 3


def test_a_wrong_key_and_missing_signatures_are_refused_counted_and_told_once() -> None:
    judge = signer()
    session = MavlinkSession(254, 5.0, {0: judge})
    events: list[Event] = []
    stranger, open_vehicle = foreign(OTHER_KEY, system_id=2), foreign(None, system_id=3)
    for _ in range(3):
        events += session.feed(pack(stranger) + pack(open_vehicle), A, 0.0)
    assert session.records == {}
    assert (judge.counts[SignatureCheck.WRONG_KEY], judge.counts[SignatureCheck.UNSIGNED]) == (3, 3)
    told = texts(events)
    assert len(told) == 2
    assert "system id 2 at 10.0.0.1:5001 are refused: signed with another key" in told[0]
    assert "not signed; set the key on the vehicle, or append unsigned=accept" in told[1]


def test_unsigned_packets_may_be_accepted_but_never_wrongly_signed_ones() -> None:
    session = MavlinkSession(254, 5.0, {0: signer(accepts_unsigned=True)})
    session.feed(pack(foreign(None, system_id=3)) + pack(foreign(OTHER_KEY, system_id=2)), A, 0.0)
    assert list(session.records) == [3]


def test_mavlink_1_counts_as_unsigned() -> None:
    packet = mavlink.MAVLink_heartbeat_message(*HEARTBEAT).pack(foreign(None), force_mavlink1=True)
    assert signer().verify(packet, (1, 1)) is SignatureCheck.UNSIGNED


def test_radios_need_no_key() -> None:
    judge = signer()
    packet = mavlink.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7).pack(foreign(None, system_id=51))
    (message,) = FrameParser().feed(packet)
    assert judge.accepts(judge.check(message), message)


def test_a_link_without_a_key_takes_everything() -> None:
    session = MavlinkSession(254, 5.0, {1: signer()})
    session.feed(pack(foreign(OTHER_KEY)), A, 0.0)
    assert list(session.records) == [1]


def test_a_recorded_packet_is_refused_the_second_time() -> None:
    judge, packet = signer(), pack(foreign())
    assert judge.verify(packet, (1, 1)) is SignatureCheck.GOOD
    assert judge.verify(packet, (1, 1)) is SignatureCheck.REPLAYED


def test_a_new_sender_may_be_late_by_a_minute_and_a_later_one_is_called_so_that_it_learns_the_time() -> None:
    assert signer().verify(pack(foreign(utc_s=UTC_S - 59.0)), (1, 1)) is SignatureCheck.GOOD
    session = MavlinkSession(254, 5.0, {0: signer()})
    vehicle = foreign(utc_s=UTC_S - 86_400.0)
    told = texts(session.feed(pack(vehicle), A, 0.0))
    assert "a vehicle whose clock is slow is being sent the time" in told[0]
    session.send_heartbeat(0.0)
    (outgoing,) = session.take_outgoing()
    vehicle.decode(bytearray(outgoing.packet))
    session.feed(pack(vehicle), A, 1.0)
    assert list(session.records) == [1]


def test_a_forged_packet_with_a_far_time_does_not_shut_the_sender_out() -> None:
    judge, vehicle = signer(), foreign()
    judge.verify(pack(foreign(OTHER_KEY, utc_s=UTC_S + 1e6)), (1, 1))
    assert judge.verify(pack(vehicle), (1, 1)) is SignatureCheck.GOOD


def test_we_go_on_from_the_time_of_a_vehicle_that_is_ahead() -> None:
    session = MavlinkSession(254, 5.0, {0: signer()})
    vehicle = foreign(utc_s=UTC_S + 3600.0)
    session.feed(pack(vehicle), A, 0.0)
    session.send_heartbeat(0.0)
    vehicle.decode(bytearray(session.take_outgoing()[0].packet))
    assert vehicle.signing.badsig_count == 0


def test_a_packet_of_one_link_is_a_replay_on_every_other_with_the_same_key(tmp_path: Path) -> None:
    path = key_file(tmp_path)
    same = path.with_name("copy.key")
    shutil.copy(path, same)
    links = [f"udpin://0.0.0.0:{14550 + number}?sign={file}" for number, file in enumerate((path, path, same))]
    signers = Keyring([parse_link(link) for link in links], FixedClock(UTC_S)).signers  # type: ignore[arg-type]
    vehicle = foreign()
    packets = [pack(vehicle) for _ in range(70)]
    assert {signers[0].verify(packet, (1, 1)) for packet in packets} == {SignatureCheck.GOOD}
    for link in (1, 2):
        assert {signers[link].verify(packet, (1, 1)) for packet in packets} == {SignatureCheck.REPLAYED}


@pytest.mark.parametrize("is_crash", [False, True])
def test_packets_are_replays_after_a_restart_too(tmp_path: Path, is_crash: bool) -> None:
    link = parse_link(f"udpin://0.0.0.0:14550?sign={key_file(tmp_path)}")
    keyring = Keyring([link], FixedClock(UTC_S))  # type: ignore[arg-type]
    vehicle = foreign()
    packets = [pack(vehicle) for _ in range(70)]
    assert {keyring.signers[0].verify(packet, (1, 1)) for packet in packets} == {SignatureCheck.GOOD}
    if is_crash:
        keyring._store(0)  # what the last period has written
    else:
        keyring.close()
    again = Keyring([link], FixedClock(UTC_S)).signers[0]  # type: ignore[arg-type]
    assert {again.verify(packet, (1, 1)) for packet in packets} == {SignatureCheck.REPLAYED}
    assert again.verify(pack(vehicle), (1, 1)) is SignatureCheck.GOOD
    assert (tmp_path / "mavlink.key.streams").stat().st_mode & 0o077 == 0


def test_a_damaged_memory_of_senders_keeps_nobody_from_starting(tmp_path: Path) -> None:
    link = parse_link(f"udpin://0.0.0.0:14550?sign={key_file(tmp_path)}")
    (tmp_path / "mavlink.key.streams").write_bytes(b"1 2\n\xff")
    assert Keyring([link], FixedClock(UTC_S)).signers[0].verify(pack(foreign()), (1, 1)) is SignatureCheck.GOOD  # type: ignore[arg-type]


@pytest.mark.parametrize("before_end", [0, 1, 100])
def test_a_time_near_the_end_of_all_times_does_not_take_ours_along(before_end: int) -> None:
    clock = SigningClock(lambda: UTC_S, 0)
    judge, vehicle = LinkSigner(0, KEY, clock, accepts_unsigned=False), foreign()
    vehicle.signing.timestamp = 2**48 - 1 - before_end
    assert judge.verify(pack(vehicle), (1, 1)) is SignatureCheck.FAR_AHEAD
    assert clock.next_ticks() < ticks_of(UTC_S) + 10
    assert judge.verify(pack(foreign()), (1, 1)) is SignatureCheck.GOOD


def test_our_own_times_do_not_wrap() -> None:
    clock = SigningClock(lambda: UTC_S, 2**48 - 2)
    assert [clock.next_ticks() for _ in range(3)] == [2**48 - 1] * 3


def test_senders_are_bounded() -> None:
    judge = signer()
    for number in range(4200):
        end = mavlink.MAVLink(None, srcSystem=1 + number % 250, srcComponent=1)
        end.signing.secret_key, end.signing.sign_outgoing = KEY, True
        end.signing.timestamp, end.signing.link_id = ticks_of(UTC_S), number // 250
        judge.verify(pack(end), (1 + number % 250, 1))
    assert len(judge._memory.latest_ticks) == 4096


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-1e4, 1e4), min_size=2, max_size=50))
def test_times_always_grow_whatever_the_clock_does(steps_s: list[float]) -> None:
    now_s = UTC_S
    clock = SigningClock(lambda: now_s, 0)
    times = []
    for step_s in steps_s:
        now_s += step_s
        times.append(clock.next_ticks())
    assert all(later > earlier for earlier, later in itertools.pairwise(times))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_no_damaged_packet_is_ever_good(data: st.DataObject) -> None:
    packet = bytearray(pack(foreign()))
    position = data.draw(st.integers(3, len(packet) - 1))
    packet[position] ^= data.draw(st.integers(1, 255))
    assert signer().verify(bytes(packet), (1, 1)) is SignatureCheck.WRONG_KEY


# --- files ----------------------------------------------------------------------------------------------------------


def key_file(folder: Path, content: bytes = KEY.hex().encode() + b"\n", mode: int = 0o600) -> Path:
    path = folder / "mavlink.key"
    path.write_bytes(content)
    path.chmod(mode)
    return path


class FixedClock:
    """A computer whose clock the test sets."""

    def __init__(self, utc_s: float) -> None:
        self.utc = utc_s

    def utc_s(self) -> float:
        return self.utc


def test_a_key_is_64_digits_or_32_bytes(tmp_path: Path) -> None:
    assert read_key(key_file(tmp_path)) == KEY
    assert read_key(key_file(tmp_path, KEY)) == KEY


@pytest.mark.parametrize(
    ("content", "mode", "words"),
    [
        (KEY.hex().encode(), 0o640, "may be read by others: run chmod 600"),
        (KEY.hex().encode(), 0o604, "may be read by others: run chmod 600"),
        (b"", 0o600, "holds no key"),
        (b"secret", 0o600, "64 hexadecimal digits"),
        (b"ab" * 33, 0o600, "holds no key"),
        (b"\xff" * 40, 0o600, "holds no key"),
    ],
)
def test_unsafe_and_useless_key_files_are_refused(tmp_path: Path, content: bytes, mode: int, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        read_key(key_file(tmp_path, content, mode))


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="cannot be read: No such file or directory; check sign="):
        read_key(tmp_path / "none.key")


def test_times_never_go_back_over_restarts_with_a_clock_that_does(tmp_path: Path) -> None:
    address = parse_link(f"udpin://0.0.0.0:14550?sign={key_file(tmp_path)}")
    last = 0
    for utc_s, is_killed in ((UTC_S, False), (UTC_S - 1e6, False), (0.0, True), (UTC_S - 5.0, True)):
        keyring = Keyring([address], FixedClock(utc_s))  # type: ignore[arg-type]
        for _ in range(5):
            encoder = mavlink.MAVLink(None)
            keyring.signers[0].prepare(encoder)
            assert encoder.signing.timestamp > last
            last = encoder.signing.timestamp
        if not is_killed:
            keyring.close()
    assert last < ticks_of(UTC_S) + 60 * TICKS_PER_S, "restarts do not run ahead of the time"


def test_the_noted_time_is_private_and_a_damaged_one_is_named(tmp_path: Path) -> None:
    path = time_file_of(key_file(tmp_path))
    assert read_ticks(path) == 0
    write_ticks(path, 77)
    assert (read_ticks(path), path.stat().st_mode & 0o777) == (77, 0o600)
    path.write_text("?")
    with pytest.raises(ConfigurationError, match="delete it if this computer's clock is right"):
        read_ticks(path)


def test_a_key_in_an_unwritable_folder_is_refused(tmp_path: Path) -> None:
    path = key_file(tmp_path)
    time_file_of(path).with_name(path.name + ".time.part").mkdir()
    with pytest.raises(ConfigurationError, match="the time of a key is stored beside it"):
        Keyring([parse_link(f"udpin://0.0.0.0:14550?sign={path}")], FixedClock(UTC_S))  # type: ignore[arg-type]
