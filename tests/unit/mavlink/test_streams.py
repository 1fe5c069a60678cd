"""Streams and facts that a session asks vehicles for, and what a restart does to them."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.session import MavlinkSession
from aos_gcs.ports import LandedState
from tests.fakes.mavlink_session import new_session, notices, requested
from tests.fakes.mavlink_vehicle import COPTER_GUIDED, HOME, FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)


def test_streams_are_requested_one_after_the_other_and_lost_requests_again() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    interval = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    session.poll(0.0)
    assert requested(session.take_outgoing(), interval) == [mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT]
    session.poll(0.5)
    assert requested(session.take_outgoing(), interval) == []
    session.poll(1.1)
    assert requested(session.take_outgoing(), interval) == [mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT]
    asked = []
    for step in range(30):
        session.feed(vehicle.ack(interval, mavlink.MAV_RESULT_FAILED if step % 2 else 0), A, 1.2 + step / 100)
        asked += requested(session.take_outgoing(), interval)
    assert len(asked) == len(set(asked)) == len(session.records[1].streams._rates_hz) - 1
    assert mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT in asked


def test_the_fast_streams_of_px4_are_slowed_down_or_switched_off_before_others_are_asked_for() -> None:
    session = new_session()
    vehicle = FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_PX4)
    session.feed(vehicle.heartbeat(), A, 0.0)
    asked = []
    for step in range(12):
        session.poll(step / 10)
        session.feed(vehicle.ack(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0), A, step / 10)
        asked += requested(session.take_outgoing(), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)
    quiet = session.records[1].autopilot.quiet_message_ids
    fast = [mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, mavlink.MAVLINK_MSG_ID_ATTITUDE, *quiet]
    assert asked[: len(fast)] == fast
    assert len(asked) > len(fast)


def answer_streams(session: MavlinkSession, vehicle: FakeVehicle, now_s: float) -> None:
    for _ in range(40):
        session.poll(now_s)
        session.feed(vehicle.ack(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0), A, now_s)
    session.take_outgoing()


def test_a_stream_that_does_not_come_is_requested_again_but_not_for_ever() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    answer_streams(session, vehicle, 0.0)
    asked = []
    for step in range(500):
        now_s = step / 5
        session.feed(vehicle.position() + vehicle.sys_status(), A, now_s)
        session.poll(now_s)
        session.feed(vehicle.ack(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0), A, now_s)
        asked += requested(session.take_outgoing(), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)
    assert asked.count(mavlink.MAVLINK_MSG_ID_GPS_RAW_INT) == 3
    assert mavlink.MAVLINK_MSG_ID_SYS_STATUS not in asked


def test_a_rate_that_drops_is_requested_again() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    answer_streams(session, vehicle, 0.0)
    for step in range(60):
        session.feed(vehicle.telemetry() + vehicle.ack(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0), A, step / 5)
        session.poll(step / 5)
    assert mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT not in requested(
        session.take_outgoing(), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    )
    for step in range(12):
        session.feed(vehicle.telemetry() + vehicle.ack(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0), A, 12.0 + step)
        session.poll(12.0 + step)
    assert mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT in requested(
        session.take_outgoing(), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    )


def positions(
    session: MavlinkSession, vehicle: FakeVehicle, peer: PeerAddress, from_s: float, number: int
) -> list[str]:
    """Hear a few positions, five a second, and return what is told."""
    told = []
    for index in range(number):
        vehicle.boot_ms += 200
        told += notices(session.feed(vehicle.position(), peer, from_s + 0.2 * index))
    return [notice.text for notice in told]


def test_a_reboot_forgets_home_and_requests_everything_again() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    answer_streams(session, vehicle, 0.0)
    vehicle.boot_ms = 50
    assert positions(session, vehicle, A, 1.0, 3) == ["has restarted"]
    assert session.records[1].state(1.5).home is None
    session.poll(1.6)
    outgoing = session.take_outgoing()
    assert requested(outgoing, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL) == [mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT]
    assert mavlink.MAVLINK_MSG_ID_HOME_POSITION in requested(outgoing, mavlink.MAV_CMD_REQUEST_MESSAGE)


@pytest.mark.parametrize("late_s", [2.5, 20.0])
def test_late_packets_are_no_reboot_however_many(late_s: float) -> None:
    session = new_session()
    vehicle = FakeVehicle()
    vehicle.boot_ms = 300_000
    vehicle.armed, vehicle.landed = True, mavlink.MAV_LANDED_STATE_IN_AIR
    session.feed(vehicle.telemetry(), A, 0.0)
    late = [vehicle.position() for _ in range(12)]
    vehicle.boot_ms += round(late_s * 1000)
    assert positions(session, vehicle, A, late_s, 1) == []
    for index, packet in enumerate(late):
        assert notices(session.feed(packet, A, late_s + 0.1 + 0.05 * index)) == []
    state = session.records[1].state(late_s + 1.0)
    assert (state.armed, state.landed) == (True, LandedState.IN_AIR)


def test_a_vehicle_that_restarts_in_the_air_is_not_taken_for_landed() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    vehicle.armed, vehicle.landed = True, mavlink.MAV_LANDED_STATE_IN_AIR
    session.feed(vehicle.telemetry(), A, 0.0)
    vehicle.boot_ms = 50
    assert positions(session, vehicle, A, 1.0, 3) == ["has restarted"]
    state = session.records[1].state(1.5)
    assert (state.armed, state.armed_at_s, state.landed) == (True, None, LandedState.UNKNOWN)


def test_a_restart_at_a_new_port_is_reported() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    vehicle.boot_ms = 50
    moved = positions(session, vehicle, A._replace(port=5009), 4.0, 5)
    assert moved == ["is now reached at 10.0.0.1:5009", "has restarted"]


def test_a_move_to_a_new_port_is_no_restart() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    vehicle.boot_ms += 4000
    assert positions(session, vehicle, A._replace(port=5009), 4.0, 20) == ["is now reached at 10.0.0.1:5009"]


def test_a_companion_does_not_hide_a_silent_autopilot() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    for tick in range(1, 100):
        session.feed(vehicle.camera_heartbeat(), A, tick / 10)
    state = session.records[1].state(9.9)
    assert state.heard_at_s == 0.0
    assert [(each.component_id, each.name, each.heard_at_s) for each in state.components] == [(100, "camera", 9.9)]


def test_home_is_asked_for_until_it_comes() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    count = 0
    for step in range(100):
        session.poll(step / 2)
        count += requested(session.take_outgoing(), mavlink.MAV_CMD_REQUEST_MESSAGE).count(242)
    assert count >= 10
    session.feed(vehicle.home(), A, 51.0)
    session.poll(60.0)
    assert 242 not in requested(session.take_outgoing(), mavlink.MAV_CMD_REQUEST_MESSAGE)


def test_a_camera_is_found_by_its_heartbeat_and_asked_about_itself() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat() + vehicle.camera_heartbeat(), A, 0.0)
    camera = session.records[1].camera
    assert camera is not None
    assert camera.component_id == 100
    session.poll(0.1)
    asked = requested(session.take_outgoing(), mavlink.MAV_CMD_REQUEST_MESSAGE)
    assert {mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION, mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS} <= set(asked)


@pytest.mark.parametrize(
    ("type_mask", "is_taken_over"),
    [(0b1101_1111_1000, False), (0b1100_0000_0111, True), (0b1100_0011_1111, True)],
    ids=["its position", "velocity", "acceleration"],
)
def test_targets_of_arducopter_that_are_no_position_are_those_of_another_station(
    type_mask: int, is_taken_over: bool
) -> None:
    """Masks as ArduCopter in software has sent them in GUIDED; meanwhile it reports no global target."""
    session, vehicle = new_session(), FakeVehicle()
    vehicle.armed, vehicle.custom_mode = True, COPTER_GUIDED
    session.feed(vehicle.heartbeat(), A, 0.0)
    control = session.records[1].control
    control.begin(frozenset({"GUIDED"}), HOME)
    control.confirm(HOME, 1.0, has_target=True)
    target = mavlink.MAVLink_position_target_local_ned_message(0, mavlink.MAV_FRAME_LOCAL_NED, type_mask, *[1.0] * 11)
    for second in range(3, 6):
        session.feed(vehicle.heartbeat() + vehicle.encoder.pack(target), A, float(second))
    assert bool(session.records[1].state(6.0).taken_over) is is_taken_over


def test_an_arducopter_in_guided_that_reports_no_target_is_asked_for_it_and_then_taken_over() -> None:
    session, vehicle = new_session(), FakeVehicle()
    vehicle.armed, vehicle.custom_mode = True, COPTER_GUIDED
    session.feed(vehicle.heartbeat(), A, 0.0)
    record = session.records[1]
    record.control.begin(frozenset({record.telemetry.mode_name}), HOME)
    its_position = mavlink.MAVLink_position_target_local_ned_message(
        0, mavlink.MAV_FRAME_LOCAL_NED, 0b1101_1111_1000, *[1.0] * 11
    )
    session.feed(vehicle.encoder.pack(its_position), A, 1.0)
    asked: list[int] = []
    for second in range(2, 12):
        assert record.state(float(second)).taken_over == ""
        session.feed(vehicle.heartbeat(), A, float(second))
        session.poll(float(second))
        asked += requested(session.take_outgoing(), mavlink.MAV_CMD_REQUEST_MESSAGE)
    assert mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED in asked
    assert "no target" in record.state(12.0).taken_over
