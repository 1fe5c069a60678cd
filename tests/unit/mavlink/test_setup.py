"""Parameters and fences on their way: without any link."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.exchange import Exchange
from aos_drivers.vehicle.fence.items import items_of, polygons_of
from aos_drivers.vehicle.fence.transfer import FenceDownload, FenceUpload
from aos_drivers.vehicle.parameters.encoding import Parameter, ParameterEncoding
from aos_drivers.vehicle.parameters.transfer import ParameterRead, ParameterWrite
from aos_gcs.errors import CommandRefusedError
from aos_gcs.ports import Geofence

TARGET = Target(7, 1)
OURS = 254
INT32, REAL32 = mavlink.MAV_PARAM_TYPE_INT32, mavlink.MAV_PARAM_TYPE_REAL32
SQUARE = ((48.0, 14.0), (48.0, 14.001), (48.001, 14.001), (48.001, 14.0))
NOTCH = ((48.0002, 14.0002), (48.0002, 14.0004), (48.0004, 14.0003))
FENCE = Geofence(SQUARE, (NOTCH,))
CAST, BYTEWISE = ParameterEncoding.CAST, ParameterEncoding.BYTEWISE

degrees = st.tuples(st.floats(-80.0, 80.0), st.floats(-179.0, 179.0))
rings = st.lists(degrees, min_size=3, max_size=9).map(tuple)


def over_the_wire(message: mavlink.MAVLink_message, system_id: int = 7) -> mavlink.MAVLink_message:
    """Encode and decode, as a link does."""
    packet = message.pack(mavlink.MAVLink(None, system_id, 1))
    (decoded,) = mavlink.MAVLink(None).parse_buffer(packet)
    return decoded


def value_of(name: str, value: float, kind: int = REAL32) -> mavlink.MAVLink_message:
    return over_the_wire(mavlink.MAVLink_param_value_message(name.encode(), value, kind, 1, 0))


def parameters(**values: float) -> dict[str, Parameter]:
    return {name: Parameter(value, REAL32) for name, value in values.items()}


# --- parameters -----------------------------------------------------------------------------------------------------


@given(st.integers(-(2**31), 2**31 - 1))
def test_an_integer_travels_bytewise_to_the_last_bit(value: int) -> None:
    # A signalling NaN becomes a quiet one in Python's conversion, which changes the bit that tells them apart.
    carrier = np.frombuffer(np.int32(value).tobytes(), np.float32)[0]
    if np.isnan(carrier) and not value & 0x00400000:
        return
    sent = mavlink.MAVLink_param_set_message(7, 1, b"P", BYTEWISE.encode(value, INT32), INT32)
    assert BYTEWISE.decode(over_the_wire(sent).param_value, INT32) == value


@pytest.mark.parametrize("encoding", ParameterEncoding)
def test_floats_travel_as_they_are(encoding: ParameterEncoding) -> None:
    assert encoding.decode(encoding.encode(1.5, REAL32), REAL32) == 1.5


def test_integers_of_ardupilot_travel_as_floats() -> None:
    assert CAST.encode(254.0, INT32) == 254.0
    assert CAST.decode(254.0, INT32) == 254.0


def test_reading_asks_again_for_what_is_missing_alone() -> None:
    read = ParameterRead(TARGET, CAST, [("NEW", "OLD"), ("B",)], ["MAYBE"])
    assert names(read.poll(0.0)) == ["NEW", "OLD", "B", "MAYBE"]
    assert read.poll(0.1) == []
    read.on_message(value_of("OLD", 3.0))
    read.on_message(value_of("OTHER", 3.0))
    assert names(read.poll(1.0)) == ["B", "MAYBE"]
    read.on_message(value_of("B", 4.0))
    assert not read.is_done
    for second in range(2, 20):
        assert set(names(read.poll(float(second)))) == {"MAYBE", "OLD"}
        assert not read.is_done, "on a link that loses everything, nothing is known to be missing"
    for second in range(20, 30):
        read.on_message(value_of("OLD", 3.0))
        read.poll(float(second))
    assert read.is_done, "a parameter that may be missing must not be waited for without end"
    assert {name: parameter.value for name, parameter in read.found.items()} == {"OLD": 3.0, "B": 4.0}


def test_reading_never_gives_up_what_has_to_exist() -> None:
    read = ParameterRead(TARGET, CAST, [("A",)])
    for second in range(0, 500, 5):
        assert names(read.poll(float(second))) == ["A"]
    assert not read.is_done


def test_reading_over_a_link_that_answers_late_asks_ever_more_rarely_until_it_does() -> None:
    read = ParameterRead(TARGET, CAST, [("A",), ("B",)])
    asked_s = [tenth / 10 for tenth in range(150) if read.poll(tenth / 10)]
    assert len(asked_s) <= 6
    assert max(after - before for before, after in itertools.pairwise(asked_s)) <= 4.1
    read.on_message(value_of("A", 1.0))
    assert names(read.poll(20.0)) == ["B"]
    assert names(read.poll(20.8)) == ["B"], "it answers again: lost ones are repeated soon"


def test_writing_waits_for_the_value_and_repeats() -> None:
    write = ParameterWrite(TARGET, BYTEWISE, {"GF_ACTION": Parameter(2.0, INT32), "ALT": Parameter(45.1, REAL32)})
    assert names(write.poll(0.0)) == ["GF_ACTION", "ALT"]
    write.on_message(value_of("GF_ACTION", BYTEWISE.encode(2.0, INT32), INT32))
    assert names(write.poll(1.0)) == ["ALT"]
    write.on_message(value_of("ALT", 45.1))
    assert write.is_done


def test_a_vehicle_that_keeps_its_value_is_not_asked_without_end() -> None:
    write = ParameterWrite(TARGET, CAST, parameters(FENCE_TYPE=5.0))
    for second in range(0, 20, 5):
        write.poll(float(second))
        write.on_message(value_of("FENCE_TYPE", 7.0))
    with pytest.raises(CommandRefusedError, match="does not accept FENCE_TYPE = 5"):
        write.poll(20.0)


def test_late_answers_to_a_read_are_no_refusal_of_the_write_that_follows() -> None:
    write = ParameterWrite(TARGET, CAST, parameters(FENCE_TYPE=5.0))
    write.poll(0.0)
    for _ in range(5):
        write.on_message(value_of("FENCE_TYPE", 7.0))
    assert names(write.poll(1.0)) == ["FENCE_TYPE"]
    write.on_message(value_of("FENCE_TYPE", 5.0))
    assert write.is_done


def names(messages: list[mavlink.MAVLink_message]) -> list[str]:
    return [message.param_id for message in messages]


# --- fences ---------------------------------------------------------------------------------------------------------


@given(rings, st.lists(rings, max_size=3))
def test_polygons_survive_as_items(inclusion: tuple, exclusions: list) -> None:
    items = [over_the_wire(item) for item in items_of(Geofence(inclusion, tuple(exclusions)), TARGET)]
    assert [item.seq for item in items] == list(range(len(items)))
    stays_in, stays_out, others = polygons_of(items)
    assert (len(stays_in), others) == (1, 0)
    assert Geofence(stays_in[0], tuple(stays_out)).is_same_as(Geofence(inclusion, tuple(exclusions)))


@given(st.lists(st.tuples(st.sampled_from([5001, 5002, 5003, 5004, 16]), st.floats(width=16)), max_size=8))
def test_items_of_others_never_break_the_reading(found: list[tuple[int, float]]) -> None:
    items = [
        mavlink.MAVLink_mission_item_int_message(254, 190, seq, 0, command, 0, 0, count, 0, 0, 0, 0, 0, 0, 1)
        for seq, (command, count) in enumerate(found)
    ]
    stays_in, stays_out, others = polygons_of(items)
    assert sum(map(len, stays_in)) + sum(map(len, stays_out)) + others == len(items)


def test_fences_differ_by_what_limits_a_flight() -> None:
    fence = Geofence(SQUARE, (NOTCH,), 45.0)
    assert fence.is_same_as(Geofence(tuple((a + 1e-7, b) for a, b in SQUARE), (NOTCH,), 45.05))
    for other in (
        Geofence(SQUARE, (), 45.0),
        Geofence(SQUARE, (NOTCH,), 46.0),
        Geofence(SQUARE, (NOTCH,)),
        Geofence(SQUARE, (NOTCH,), 45.0, radius_about_home_m=100.0),
        Geofence(SQUARE, (NOTCH,), 45.0, other_items=1),
        Geofence(tuple((a + 1e-6, b) for a, b in SQUARE), (NOTCH,), 45.0),
        Geofence(SQUARE[:3], (NOTCH,), 45.0),
    ):
        assert not fence.is_same_as(other)


def request(seq: int, mission_type: int = 1, target: int = OURS) -> mavlink.MAVLink_message:
    return over_the_wire(mavlink.MAVLink_mission_request_int_message(target, 190, seq, mission_type))


def acknowledge(result: int, mission_type: int = 1) -> mavlink.MAVLink_message:
    return over_the_wire(mavlink.MAVLink_mission_ack_message(OURS, 190, result, mission_type))


def test_an_upload_answers_every_request_once() -> None:
    upload = FenceUpload(TARGET, items_of(FENCE, TARGET), OURS)
    (count,) = upload.poll(0.0)
    assert (count.count, count.mission_type) == (7, 1)
    upload.on_message(request(0, target=99))
    upload.on_message(request(0, mission_type=0))
    assert upload.poll(0.5) == [], "requests of others are none of ours"
    for seq in (0, 1, 1, 2, 3, 4, 5, 6):
        upload.on_message(request(seq))
        assert [item.seq for item in upload.poll(1.0)] == [seq]
        assert upload.poll(3.0) == [], "an item that comes unasked is out of sequence"
        upload.on_message(acknowledge(mavlink.MAV_MISSION_INVALID_SEQUENCE))
        if seq < 6:
            upload.on_message(acknowledge(mavlink.MAV_MISSION_ACCEPTED))
            assert not upload.is_done
    upload.on_message(acknowledge(mavlink.MAV_MISSION_ACCEPTED))
    assert upload.is_done


def test_an_upload_starts_over_when_nobody_asks_any_more() -> None:
    upload = FenceUpload(TARGET, items_of(FENCE, TARGET), OURS)
    upload.poll(0.0)
    upload.on_message(request(0))
    upload.poll(0.1)
    assert upload.poll(4.0) == []
    assert [message.get_type() for message in upload.poll(6.0)] == ["MISSION_COUNT"]


def test_an_upload_starts_over_when_the_vehicle_has_given_up() -> None:
    upload = FenceUpload(TARGET, items_of(FENCE, TARGET), OURS)
    upload.poll(0.0)
    upload.on_message(request(3))
    upload.poll(0.1)
    upload.on_message(acknowledge(mavlink.MAV_MISSION_OPERATION_CANCELLED))
    assert [message.get_type() for message in upload.poll(0.2)] == ["MISSION_COUNT"]


def test_a_refused_upload_says_why() -> None:
    upload = FenceUpload(TARGET, items_of(FENCE, TARGET), OURS)
    upload.poll(0.0)
    upload.on_message(acknowledge(mavlink.MAV_MISSION_NO_SPACE))
    with pytest.raises(CommandRefusedError, match="vehicle 7 refuses a geofence of 7 points: no space"):
        upload.poll(0.1)


def test_a_download_asks_again_for_lost_items() -> None:
    items = items_of(FENCE, Target(OURS, 190))
    download = FenceDownload(TARGET, OURS)
    assert [message.get_type() for message in download.poll(0.0)] == ["MISSION_REQUEST_LIST"]
    download.on_message(over_the_wire(mavlink.MAVLink_mission_count_message(OURS, 190, 7, 1)))
    for seq, item in enumerate(items):
        assert [message.seq for message in download.poll(10.0 * seq)] == [seq]
        assert download.poll(10.0 * seq + 0.1) == []
        assert [message.seq for message in download.poll(10.0 * seq + 5.0)] == [seq]
        download.on_message(over_the_wire(item))
        download.on_message(over_the_wire(item))
    assert [message.get_type() for message in download.poll(100.0)] == ["MISSION_ACK"]
    assert download.is_done
    assert polygons_of(download.items)[2] == 0


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (mavlink.MAVLink_mission_ack_message(OURS, 190, mavlink.MAV_MISSION_UNSUPPORTED, 1), "unsupported"),
        (mavlink.MAVLink_mission_count_message(OURS, 190, 60_000, 1), "more than any autopilot"),
    ],
)
def test_a_download_that_cannot_be_is_refused(answer: mavlink.MAVLink_message, text: str) -> None:
    download = FenceDownload(TARGET, OURS)
    download.poll(0.0)
    download.on_message(over_the_wire(answer))
    with pytest.raises(CommandRefusedError, match=text):
        download.poll(0.1)


MESSAGES = st.one_of(
    st.builds(request, st.integers(0, 65535), st.integers(0, 255)),
    st.builds(acknowledge, st.integers(0, 255), st.integers(0, 3)),
    st.builds(
        lambda count: over_the_wire(mavlink.MAVLink_mission_count_message(OURS, 190, count, 1)), st.integers(0, 65535)
    ),
    st.builds(
        lambda seq, command, x, count: over_the_wire(
            mavlink.MAVLink_mission_item_int_message(OURS, 190, seq, 0, command, 0, 0, count, 0, 0, 0, x, x, 0, 1)
        ),
        st.integers(0, 65535),
        st.integers(0, 65535),
        st.integers(-(2**31), 2**31 - 1),
        st.floats(width=32),
    ),
    st.builds(lambda value, kind: value_of("A", value, kind), st.floats(width=32), st.integers(0, 255)),
)


@given(st.lists(MESSAGES, max_size=30))
def test_no_message_breaks_a_conversation(messages: list[mavlink.MAVLink_message]) -> None:
    for exchange in _exchanges():
        for second, message in enumerate(messages):
            exchange.on_message(message)
            try:
                sent = exchange.poll(float(second))
            except CommandRefusedError:
                break
            assert len(sent) <= 2
        if isinstance(exchange, FenceDownload):
            polygons_of(exchange.items)


def _exchanges() -> Iterator[Exchange]:
    yield FenceUpload(TARGET, items_of(FENCE, TARGET), OURS)
    yield FenceDownload(TARGET, OURS)
    yield ParameterRead(TARGET, BYTEWISE, [("A",)])
    yield ParameterWrite(TARGET, BYTEWISE, parameters(A=1.0))
