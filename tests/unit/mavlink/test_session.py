"""State and texts of vehicles, from their packets."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_gcs.ports import FlightMode, LandedState, Severity
from tests.fakes.mavlink_session import new_session, notices, requested
from tests.fakes.mavlink_vehicle import HOME, Encoder, FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)


# --- state ----------------------------------------------------------------------------------------------------------


def test_values_that_were_never_reported_are_none() -> None:
    session = new_session()
    session.feed(FakeVehicle().heartbeat(), A, 1.0)
    state = session.records[1].state(1.0)
    assert state.autopilot == "arducopter"
    assert (state.mode, state.mode_name) == (FlightMode.MANUAL, "STABILIZE")
    assert (state.position, state.home, state.battery_fraction, state.gps_fix, state.ready_to_arm) == (None,) * 5
    assert state.landed is LandedState.UNKNOWN
    assert state.heard_at_s == 1.0


def test_messages_of_newer_dialects_are_no_loss() -> None:
    session, vehicle = new_session(), FakeVehicle()
    for number in range(60):
        packet = bytearray(vehicle.heartbeat())
        if number % 2:
            packet[7:10] = b"\xff\x3f\x00"  # no dialect has a message 16383
        session.feed(bytes(packet), A, 1.0 + number)
    assert session.records[1].loss_fraction() == 0.0


def test_telemetry_becomes_state_in_our_frames_and_units() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    vehicle.height_m, vehicle.velocity_ned_cmps = 20.0, (100, 200, -50)
    session.feed(vehicle.telemetry(), A, 4.0)
    vehicle.longitude_deg += 1e-5
    session.feed(vehicle.telemetry(), A, 5.0)
    state = session.records[1].state(5.0)
    assert state.position is not None
    assert state.position.altitude_amsl_m == pytest.approx(320.0)
    assert (state.position_at_s, state.height_above_home_m) == (5.0, 20.0)
    assert state.velocity_enu_mps == (2.0, 1.0, 0.5)
    assert state.heading_rad == pytest.approx(1.5707963)
    assert state.home == HOME
    assert (state.battery_fraction, state.battery_voltage_v) == (0.83, 15.8)
    assert (state.gps_fix, state.satellites) == (3, 14)
    assert state.landed is LandedState.ON_GROUND


def test_home_is_asked_for_again_once_it_is_armed() -> None:
    """Autopilots move it then, and ArduCopter reports it once: on a radio that may be lost."""
    session, vehicle, asked = new_session(), FakeVehicle(), []
    for now_s, armed in ((1.0, False), (2.0, True), (3.0, True)):
        vehicle.armed = armed
        session.feed(vehicle.telemetry() if not armed else vehicle.heartbeat(), A, now_s)
        session.poll(now_s)
        messages = requested(session.take_outgoing(), mavlink.MAV_CMD_REQUEST_MESSAGE)
        asked.append(mavlink.MAVLINK_MSG_ID_HOME_POSITION in messages)
        session.feed(vehicle.home(), A, now_s + 0.1)
    assert asked == [False, True, False]


def test_height_is_unknown_before_home_is() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat() + vehicle.position(), A, 1.0)
    assert session.records[1].state(1.0).height_above_home_m is None
    session.feed(vehicle.home(), A, 1.1)
    assert session.records[1].state(1.1).height_above_home_m == 0.0


def test_zero_is_never_a_position() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    vehicle.latitude_deg = vehicle.longitude_deg = 0.0
    session.feed(vehicle.heartbeat() + vehicle.position(), A, 1.0)
    assert session.records[1].state(1.0).position is None


@pytest.mark.parametrize("altitude_mm", [-(2**31), 2**31 - 1])
def test_an_altitude_that_stands_for_unknown_is_no_home(altitude_mm: int) -> None:
    session, vehicle = new_session(), FakeVehicle()
    strange = mavlink.MAVLink_home_position_message(480000000, 140000000, altitude_mm, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
    session.feed(vehicle.heartbeat() + vehicle.home() + vehicle.encoder.pack(strange), A, 1.0)
    assert session.records[1].state(1.0).home == HOME


def test_ready_needs_every_condition_and_fresh_positions() -> None:
    vehicle = FakeVehicle()
    session = new_session()
    session.feed(vehicle.telemetry(), A, 1.0)
    assert session.records[1].state(1.0).ready_to_arm is True
    assert session.records[1].state(10.0).ready_to_arm is False
    for packet in (
        vehicle.sys_status(healthy=False),
        vehicle.gps(fix=2),
        vehicle.ekf(mavlink.EKF_POS_HORIZ_ABS),
        vehicle.ekf(mavlink.EKF_POS_HORIZ_REL | mavlink.EKF_POS_HORIZ_ABS | mavlink.EKF_CONST_POS_MODE),
    ):
        session.feed(vehicle.telemetry(), A, 1.0)
        session.feed(packet, A, 1.0)
        assert session.records[1].state(1.0).ready_to_arm is False


@pytest.mark.parametrize(("flags", "age_s"), [(1023, 0.0), (1023 & ~mavlink.ESTIMATOR_POS_HORIZ_ABS, 2.0)])
def test_px4_that_stands_still_has_a_position_although_it_calls_it_constant(flags: int, age_s: float) -> None:
    vehicle = FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_PX4)
    session = new_session()
    session.feed(vehicle.heartbeat() + vehicle.gps() + vehicle.home() + vehicle.sys_status(), A, 1.0)
    session.feed(vehicle.estimator(flags), A, 1.0)
    for now_s in (1.0, 2.0, 3.0):
        vehicle.boot_ms += 1000
        session.feed(vehicle.position(), A, now_s)
    state = session.records[1].state(3.0)
    assert state.position_at_s == 3.0 - age_s
    assert state.ready_to_arm is (age_s == 0.0)


@pytest.mark.parametrize(
    ("main", "sub", "mode", "name"),
    [
        (4, 3, FlightMode.HOLD, "AUTO.LOITER"),
        (4, 5, FlightMode.RETURN, "AUTO.RTL"),
        (4, 6, FlightMode.LAND, "AUTO.LAND"),
        (4, 2, FlightMode.TAKEOFF, "AUTO.TAKEOFF"),
        (3, 0, FlightMode.MANUAL, "POSCTL"),
        (42, 0, FlightMode.UNKNOWN, "mode 42.0"),
    ],
)
def test_px4_modes(main: int, sub: int, mode: FlightMode, name: str) -> None:
    session = new_session()
    vehicle = FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_PX4)
    vehicle.custom_mode = main << 16 | sub << 24
    session.feed(vehicle.heartbeat(), A, 0.0)
    state = session.records[1].state(0.0)
    assert (state.autopilot, state.mode, state.mode_name) == ("px4", mode, name)


def test_ground_stations_and_cameras_are_no_vehicles() -> None:
    session = new_session()
    station = Encoder(255, 190).pack(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3))
    session.feed(station + FakeVehicle(7).camera_heartbeat(), A, 0.0)
    assert session.records == {}


def test_an_autopilot_that_introduces_a_camera_does_not_take_the_place_of_a_camera() -> None:
    session, vehicle = new_session(), FakeVehicle()
    values = dict.fromkeys(mavlink.MAVLink_camera_information_message.fieldnames, 0)
    names = {"vendor_name": [0] * 32, "model_name": [0] * 32, "cam_definition_uri": b""}
    session.feed(vehicle.heartbeat(), A, 0.0)
    introduction = vehicle.encoder.pack(mavlink.MAVLink_camera_information_message(**values | names))
    session.feed(introduction + vehicle.camera_heartbeat(), A, 0.1)
    session.feed(introduction, A, 0.2)
    assert session.records[1].camera.component_id == mavlink.MAV_COMP_ID_CAMERA


def test_a_companion_that_leaves_its_heartbeat_at_zero_does_not_take_the_autopilots_place() -> None:
    session, companion = new_session(), Encoder(1, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER)
    session.feed(companion.pack(mavlink.MAVLink_heartbeat_message(0, 0, 0, 0, 4, 3)), A, 0.0)
    session.feed(FakeVehicle().heartbeat(), A, 1.0)
    record = session.records[1]
    assert (record.target.component_id, record.autopilot.name) == (mavlink.MAV_COMP_ID_AUTOPILOT1, "arducopter")


def test_a_stranger_with_our_own_id_is_reported_once() -> None:
    session = new_session()
    station = Encoder(254, 190)
    heartbeat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3)
    events = session.feed(station.pack(heartbeat) + station.pack(heartbeat), A, 0.0)
    assert [notice.severity for notice in notices(events)] == [Severity.WARNING]


# --- text -----------------------------------------------------------------------------------------------------------


def test_status_text_is_a_notice_and_warnings_stay_in_the_state() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    events = session.feed(vehicle.status_text("GPS glitch") + vehicle.status_text("hello", 6), A, 0.0)
    assert [(notice.severity, notice.text, notice.vehicle_id) for notice in notices(events)] == [
        (Severity.CRITICAL, "GPS glitch", 1),
        (Severity.INFO, "hello", 1),
    ]
    assert session.records[1].state(0.0).text == "GPS glitch"


@pytest.mark.parametrize("text", ["PreArm: no GPS", "Preflight Fail: compass"])
def test_why_a_vehicle_cannot_be_armed_is_no_alert_and_over_when_it_is(text: str) -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    told = notices(session.feed(vehicle.status_text(text), A, 0.0))
    assert [(notice.severity, notice.text) for notice in told] == [(Severity.INFO, text)]
    session.feed(vehicle.heartbeat(), A, 1.0)
    assert session.records[1].state(1.0).text == text
    vehicle.armed = True
    session.feed(vehicle.heartbeat(), A, 2.0)
    assert session.records[1].state(2.0).text == ""


def test_why_a_vehicle_could_not_be_armed_is_forgotten_once_its_checks_pass() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat() + vehicle.status_text("PreArm: no GPS"), A, 0.0)
    session.feed(vehicle.sys_status(healthy=False) + vehicle.heartbeat(), A, 11.0)
    assert session.records[1].state(11.0).text == "PreArm: no GPS"
    session.feed(vehicle.sys_status() + vehicle.heartbeat(), A, 12.0)
    assert session.records[1].state(12.0).text == ""


def test_chunks_of_a_text_are_joined_in_order() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    text = "x" * 50 + "y" * 50 + "end"
    chunks = [
        vehicle.encoder.pack(mavlink.MAVLink_statustext_message(4, text[50 * i : 50 * i + 50].encode(), 9, i))
        for i in range(3)
    ]
    assert notices(session.feed(chunks[0] + chunks[2], A, 0.0)) == []
    assert [notice.text for notice in notices(session.feed(chunks[1], A, 0.1))] == [text]


def test_a_text_with_a_lost_chunk_comes_late_instead_of_never() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    session.feed(vehicle.heartbeat(), A, 0.0)
    session.feed(vehicle.encoder.pack(mavlink.MAVLink_statustext_message(4, b"z" * 50, 9, 0)), A, 0.0)
    assert notices(session.poll(0.5)) == []
    assert [notice.text for notice in notices(session.poll(1.5))] == ["z" * 50]
