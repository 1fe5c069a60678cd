"""Targets and missions that other programs ask the simulated vehicles for."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

ACCEPTED, DENIED, FAILED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_FAILED
REJECTED = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
SET_MODE = mavlink.MAV_CMD_DO_SET_MODE
LOCAL, BODY = mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_NED
NO_POSITION, NO_VELOCITY, NO_ACCELERATION = 0b111, 0b111 << 3, 0b111 << 6
NO_YAW = mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
VELOCITY = NO_POSITION | NO_ACCELERATION | NO_YAW
POSITION = NO_VELOCITY | NO_ACCELERATION | NO_YAW
OFFBOARD, AUTO = 6, 3


def local(bench, mask, *, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), frame=LOCAL, yaw=0.0):
    """Send SET_POSITION_TARGET_LOCAL_NED."""
    bench.send(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 7, 1, frame, mask, *position, *velocity, 0.0, 0.0, 0.0, yaw, 0.0
        )
    )


def globe(bench, mask, point_enu_m, altitude):
    """Send SET_POSITION_TARGET_GLOBAL_INT."""
    place = bench.frame.to_geodetic(point_enu_m)
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
    degrees = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    bench.send(
        mavlink.MAVLink_set_position_target_global_int_message(
            0, 7, 1, frame, mask, *degrees, altitude, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        )
    )


def stream(bench, seconds, send):
    """Send a target four times per second."""
    for _ in range(round(seconds * 4)):
        send()
        bench.advance(0.25)


def velocity(bench):
    return tuple(bench.state.velocity_enu_mps[0])


def mode(bench):
    return bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).custom_mode


@pytest.fixture
def copter(make_flying):
    """ArduCopter in GUIDED, 20 m above home."""
    return make_flying("arducopter")


@pytest.fixture
def px4(make_flying):
    """PX4 in HOLD, 20 m above home."""
    return make_flying("px4")


@pytest.fixture
def offboard(px4):
    """PX4 in OFFBOARD, told to stand still."""
    stream(px4, 0.5, lambda: local(px4, VELOCITY))
    assert px4.long(SET_MODE, 1, OFFBOARD) == [ACCEPTED, ACCEPTED]
    return px4


def test_copter_flies_a_velocity_in_guided_and_stops_when_none_comes_for_guid_timeout(copter):
    stream(copter, 6.0, lambda: local(copter, VELOCITY, velocity=(3.0, 4.0, -1.0)))
    assert velocity(copter) == pytest.approx((4.0, 3.0, 1.0), abs=0.05)
    copter.advance(2.5)
    assert velocity(copter) == pytest.approx((4.0, 3.0, 1.0), abs=0.05)
    copter.advance(4.0)
    assert velocity(copter) == pytest.approx((0.0, 0.0, 0.0), abs=0.05)
    assert mode(copter) == 4, "it stays in GUIDED"


def test_copter_reports_no_target_while_it_follows_a_velocity(copter):
    copter.long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT, 100_000)
    copter.sent.clear()
    stream(copter, 2.0, lambda: local(copter, VELOCITY, velocity=(3.0, 0.0, 0.0)))
    assert copter.count("POSITION_TARGET_GLOBAL_INT") <= 1
    copter.advance(4.0)
    assert copter.count("POSITION_TARGET_GLOBAL_INT") > 5


def test_copter_ignores_targets_outside_guided(copter):
    assert copter.long(SET_MODE, 1, 5) == [ACCEPTED]
    stream(copter, 2.0, lambda: local(copter, VELOCITY, velocity=(5.0, 0.0, 0.0)))
    assert math.hypot(*velocity(copter)) < 0.1


@pytest.mark.parametrize("mask", [VELOCITY | NO_VELOCITY, NO_POSITION | NO_VELOCITY | NO_YAW])
def test_copter_stops_on_a_target_that_says_nothing_it_flies(copter, mask):
    stream(copter, 4.0, lambda: local(copter, VELOCITY, velocity=(5.0, 0.0, 0.0)))
    local(copter, mask)
    copter.advance(3.0)
    assert math.hypot(*velocity(copter)) < 0.1


def test_copter_flies_to_positions_of_every_frame_for_as_long_as_it_takes(copter):
    local(copter, POSITION, position=(30.0, 10.0, -25.0))
    copter.advance(15.0)
    assert copter.distance_to(10.0, 30.0, 25.0) < 0.1
    local(copter, POSITION, position=(5.0, 0.0, 0.0), frame=mavlink.MAV_FRAME_LOCAL_OFFSET_NED)
    copter.advance(8.0)
    assert copter.distance_to(10.0, 35.0, 25.0) < 0.1
    globe(copter, POSITION, (0.0, 0.0, 0.0), 22.0)
    copter.advance(15.0)
    assert copter.distance_to(0.0, 0.0, 22.0) < 0.1


def test_copter_does_not_fly_to_a_position_outside_its_fence(copter):
    local(copter, POSITION, position=(600.0, 0.0, -25.0))
    copter.advance(3.0)
    assert copter.distance_to(0.0, 0.0, 20.0) < 0.3


def test_body_velocities_go_by_the_heading(copter):
    heading_rad = copter.kinematics.heading_rad
    stream(copter, 6.0, lambda: local(copter, VELOCITY, velocity=(4.0, 0.0, 0.0), frame=BODY))
    east, north, _ = velocity(copter)
    assert (east, north) == pytest.approx((4.0 * math.sin(heading_rad), 4.0 * math.cos(heading_rad)), abs=0.1)


def test_a_heading_is_turned_to(copter):
    mask = VELOCITY & ~mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
    stream(copter, 4.0, lambda: local(copter, mask, velocity=(1.0, 0.0, 0.0), yaw=1.5))
    assert copter.kinematics.heading_rad == pytest.approx(1.5, abs=0.05)


def test_offboard_needs_targets_first(px4):
    assert px4.long(SET_MODE, 1, OFFBOARD) == [ACCEPTED, REJECTED]
    assert px4.texts()[-1] == "Switching to Offboard is currently not available"
    stream(px4, 1.0, lambda: local(px4, VELOCITY, velocity=(5.0, 0.0, 0.0)))
    assert math.hypot(*velocity(px4)) < 0.1, "targets are flown in OFFBOARD alone"
    assert px4.long(SET_MODE, 1, OFFBOARD) == [ACCEPTED, ACCEPTED]


def test_px4_flies_a_velocity_at_a_height_in_offboard(offboard):
    mask = VELOCITY & ~mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE
    stream(offboard, 8.0, lambda: local(offboard, mask, position=(0.0, 0.0, -24.0), velocity=(3.0, -4.0, 0.0)))
    assert velocity(offboard)[:2] == pytest.approx((-4.0, 3.0), abs=0.1)
    assert offboard.height_m == pytest.approx(24.0, abs=0.3)


def test_px4_flies_to_a_global_place_in_offboard(offboard):
    stream(offboard, 12.0, lambda: globe(offboard, POSITION, (15.0, 20.0, 0.0), 30.0))
    assert offboard.distance_to(15.0, 20.0, 30.0) < 0.2


@pytest.mark.parametrize(("action", "then"), [(0, 3 << 16), (3, 5 << 24 | 4 << 16), (5, 3 << 24 | 4 << 16)])
def test_px4_leaves_offboard_when_targets_stop_for_com_of_loss_t(offboard, action, then):
    offboard.autopilot.parameters["COM_OBL_RC_ACT"] = action
    stream(offboard, 2.0, lambda: local(offboard, VELOCITY, velocity=(3.0, 0.0, 0.0)))
    assert mode(offboard) == OFFBOARD << 16
    offboard.advance(1.0)
    assert mode(offboard) == then
    assert "No offboard signal" in offboard.texts()


@pytest.mark.parametrize(
    ("mask", "frame"), [(VELOCITY | NO_VELOCITY, LOCAL), (VELOCITY, mavlink.MAV_FRAME_LOCAL_OFFSET_NED)]
)
def test_px4_does_not_count_what_it_cannot_fly_as_a_target(px4, mask, frame):
    stream(px4, 1.0, lambda: local(px4, mask, frame=frame))
    assert px4.long(SET_MODE, 1, OFFBOARD) == [ACCEPTED, REJECTED]


def test_a_mission_that_does_not_exist_is_not_started(copter, px4):
    assert copter.long(mavlink.MAV_CMD_MISSION_START) == [FAILED]
    assert copter.texts()[-1] == "Mode change to AUTO failed: init failed"
    assert copter.long(mavlink.MAV_CMD_MISSION_START, 1) == [DENIED]
    assert copter.long(SET_MODE, 1, AUTO) == [FAILED]
    assert px4.long(mavlink.MAV_CMD_MISSION_START) == [DENIED]
    assert px4.texts()[-1] == "Mission start denied! No valid mission"
    assert px4.long(SET_MODE, 1, 4, 4) == [ACCEPTED, REJECTED]
    assert mode(px4) == 3 << 24 | 4 << 16


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_clearing_the_mission_that_does_not_exist_is_accepted(make_bench, flavour):
    bench = make_bench(flavour)
    replies = bench.send(mavlink.MAVLink_mission_clear_all_message(7, 1, mavlink.MAV_MISSION_TYPE_MISSION))
    assert [m.type for m in replies if m.get_type() == "MISSION_ACK"] == [mavlink.MAV_MISSION_ACCEPTED]
