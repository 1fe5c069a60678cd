from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.mavlink.peers import Outgoing
from aos_drivers.mavlink.session import Event, MavlinkSession
from aos_gcs.ports import FlightMode, LandedState, Notice, Severity
from tests.fakes.mavlink_vehicle import COPTER_GUIDED, HOME, Encoder, FakeVehicle

A, B = PeerAddress(0, "10.0.0.1", 5001), PeerAddress(0, "10.0.0.2", 5002)


def new_session() -> MavlinkSession:
    return MavlinkSession(system_id=254, position_hz=5.0)


def notices(events: list[Event]) -> list[Notice]:
    return [event for event in events if isinstance(event, Notice)]


def decoded(outgoing: list[Outgoing]) -> list[tuple[PeerAddress, mavlink.MAVLink_message]]:
    return [(entry.peer, message) for entry in outgoing for message in FrameParser().feed(entry.packet)]


def requested(outgoing: list[Outgoing], command: int) -> list[int]:
    return [
        int(message.param1)
        for _peer, message in decoded(outgoing)
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_COMMAND_LONG and message.command == command
    ]


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


# --- routes ---------------------------------------------------------------------------------------------------------


def test_messages_go_to_the_address_of_their_vehicle_alone() -> None:
    session = new_session()
    session.feed(FakeVehicle(1).heartbeat(), A, 0.0)
    session.feed(FakeVehicle(2).heartbeat(), B, 0.0)
    session.take_outgoing()
    session.send(2, 1, mavlink.MAVLink_command_long_message(2, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert [peer for peer, _message in decoded(session.take_outgoing())] == [B]
    session.feed(FakeVehicle(2).heartbeat(), A, 20.0)
    session.take_outgoing()
    session.send(2, 1, mavlink.MAVLink_command_long_message(2, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert [peer for peer, _message in decoded(session.take_outgoing())] == [A]


def test_our_heartbeat_goes_once_to_each_address_with_vehicles_and_to_called_ones() -> None:
    session = new_session()
    called = PeerAddress(1, "10.0.0.9", 14550)
    session.add_peer(called)
    session.feed(FakeVehicle(1).heartbeat() + FakeVehicle(2).heartbeat(), A, 0.0)
    session.feed(b"noise", B, 0.0)
    session.take_outgoing()
    assert session.is_heartbeat_due(0.0)
    session.send_heartbeat(0.0)
    sent = decoded(session.take_outgoing())
    assert sorted(peer for peer, _message in sent) == [A, called]
    heartbeat = sent[0][1]
    assert (heartbeat.type, heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) == (mavlink.MAV_TYPE_GCS, 254, 190)
    assert not session.is_heartbeat_due(0.9)
    assert session.is_heartbeat_due(1.0)


def test_peers_are_bounded_and_those_with_vehicles_stay() -> None:
    session = new_session()
    session.feed(FakeVehicle(1).heartbeat(), A, 0.0)
    for port in range(2000):
        session.feed(b"?", PeerAddress(0, "10.9.9.9", port), 1.0 + port)
    assert len(session._peers) == 512
    assert A in session._peers


def test_noise_of_one_peer_does_not_touch_another() -> None:
    session = new_session()
    packet = FakeVehicle(1).heartbeat()
    session.feed(packet[:10], A, 0.0)
    session.feed(b"\xfd\xff\x00" + bytes(40), B, 0.0)
    session.feed(packet[10:], A, 0.0)
    assert list(session.records) == [1]


def test_loss_is_counted_per_component() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    for number in range(40):
        session.feed(vehicle.heartbeat() + vehicle.camera_heartbeat(), A, float(number))
        vehicle.encoder.skip(1)
    loss = session.records[1].state(40.0).packet_loss_fraction
    assert loss == pytest.approx(39 / (39 + 80))


# --- identity -------------------------------------------------------------------------------------------------------


def test_two_living_addresses_with_one_id_are_critical_until_one_is_silent() -> None:
    session = new_session()
    first, second = FakeVehicle(1), FakeVehicle(1)
    events: list[Event] = []
    for step in range(4):
        events += session.feed(first.heartbeat(), A, step * 1.0)
        events += session.feed(second.heartbeat(), B, step * 1.0 + 0.5)
    events += session.poll(4.0)
    assert [notice.severity for notice in notices(events) if notice.severity is Severity.CRITICAL] == [
        Severity.CRITICAL
    ]
    assert session.records[1].identity.is_ambiguous(4.0)
    for step in range(20):
        session.feed(first.heartbeat(), A, 4.0 + step)
        session.poll(4.0 + step)
    assert not session.records[1].identity.is_ambiguous(24.0)


def test_another_board_at_a_second_address_is_ambiguous_at_once() -> None:
    session = new_session()
    first, second = FakeVehicle(1), FakeVehicle(1)
    second.uid = 77
    session.feed(first.heartbeat() + first.version(), A, 0.0)
    events = session.feed(second.heartbeat() + second.version(), B, 0.2)
    assert [notice.severity for notice in notices(events)] == [Severity.CRITICAL]


def test_a_vehicle_that_moves_to_another_address_is_still_itself() -> None:
    session = new_session()
    vehicle = FakeVehicle(1)
    session.feed(vehicle.heartbeat() + vehicle.version(), A, 0.0)
    session.feed(vehicle.heartbeat() + vehicle.version(), B, 1.0)
    session.feed(vehicle.heartbeat(), B, 2.0)
    assert not session.records[1].identity.is_ambiguous(2.0)


# --- streams and facts ----------------------------------------------------------------------------------------------


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
