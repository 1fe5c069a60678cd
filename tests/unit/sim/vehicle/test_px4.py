"""Rules of the simulated PX4."""

from __future__ import annotations

import math
import struct

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

ACCEPTED, REJECTED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_TEMPORARILY_REJECTED
ARM, TAKEOFF, SET_MODE = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_DO_SET_MODE,
)
HOLD, RETURN, LAND, AUTO_TAKEOFF = (4 << 16 | sub << 24 for sub in (3, 5, 6, 2))


@pytest.fixture
def bench(make_bench):
    bench = make_bench("px4")
    bench.heartbeats_from = 245
    bench.advance(1.1)
    return bench


@pytest.fixture
def flying(make_flying):
    """A vehicle in HOLD, 20 m above home."""
    return make_flying("px4")


def mode(bench):
    return bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).custom_mode


def test_arming_without_a_ground_station_is_refused_in_silence(make_bench):
    bench = make_bench("px4")
    assert bench.long(ARM, 1) == [REJECTED]
    assert bench.texts() == [], "status texts come only after a ground station's heartbeat"
    assert not bench.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS).onboard_control_sensors_health & (1 << 28)
    bench.heartbeat(245)
    assert bench.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS).onboard_control_sensors_health & (1 << 28)
    assert bench.long(ARM, 1) == [ACCEPTED]


def test_without_the_failsafe_it_arms_alone(make_bench):
    assert make_bench("px4", NAV_DLL_ACT=0).long(ARM, 1) == [ACCEPTED]


def test_arming_before_the_estimator_is_refused(make_bench):
    bench = make_bench("px4", start_up_s=5.0)
    bench.heartbeat(245)
    assert bench.long(ARM, 1) == [REJECTED]
    assert bench.texts() == ["Arming denied: system health failures"]


def test_default_streams_are_many(bench):
    bench.step_ticks = 1
    bench.sent.clear()
    bench.advance(10)
    assert bench.count("GLOBAL_POSITION_INT") == 500
    assert bench.count("ATTITUDE") == 500
    assert bench.count("SYS_STATUS") == 10
    assert bench.long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE, -1) == [ACCEPTED]
    bench.sent.clear()
    bench.advance(1)
    assert bench.count("ATTITUDE") == 0


def test_set_mode_is_acknowledged_twice(flying):
    assert flying.long(SET_MODE, 1, 4, 5) == [ACCEPTED, ACCEPTED]
    assert mode(flying) == RETURN
    assert flying.long(SET_MODE, 1, 4, 4) == [ACCEPTED, REJECTED], "there is no mission"
    assert mode(flying) == RETURN


def test_takeoff_altitude_is_above_sea_level_and_ends_in_hold(bench):
    bench.long(ARM, 1)
    assert bench.long(TAKEOFF, 0, 0, 0, math.nan, math.nan, math.nan, 275) == [ACCEPTED]
    assert mode(bench) == AUTO_TAKEOFF
    bench.advance(12)
    assert bench.height_m == pytest.approx(15.0, abs=0.3)
    assert mode(bench) == HOLD


def test_takeoff_without_altitude_uses_the_parameter_and_may_come_before_arming(bench):
    assert bench.long(TAKEOFF, 0, 0, 0, math.nan, math.nan, math.nan, math.nan) == [ACCEPTED]
    bench.advance(2)
    assert bench.height_m == 0.0
    bench.long(ARM, 1)
    bench.advance(8)
    assert bench.height_m == pytest.approx(2.5, abs=0.3)


def test_reposition_altitude_is_above_sea_level_in_every_frame(flying):
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
    assert flying.reposition(10, 20, 25, frame=frame, altitude=285.0) == [ACCEPTED]
    flying.advance(12)
    assert flying.distance_to(10, 20, 25) < 0.1


@pytest.mark.parametrize("flags", [0, 2, 3])
def test_reposition_without_exactly_the_mode_flag_is_refused_and_flown_in_hold_alone(flying, flags):
    flying.long(SET_MODE, 1, 4, 6)
    flying.advance(2)
    assert flying.reposition(10, 20, 25, flags=flags) == [mavlink.MAV_RESULT_UNSUPPORTED]
    flying.advance(2)
    assert flying.distance_to(0, 0, 20) < 10
    flying.long(SET_MODE, 1, 4, 3)
    assert flying.reposition(10, 20, 25, flags=flags) == [mavlink.MAV_RESULT_UNSUPPORTED]
    flying.advance(12)
    assert flying.distance_to(10, 20, 25) < 0.1


def test_reposition_heading_speed_and_kept_altitude(flying):
    assert flying.reposition(0, 100, 20, altitude=math.nan, speed=3.0, yaw=1.0) == [ACCEPTED]
    flying.advance(6)
    assert flying.state.velocity_enu_mps[0, 1] == pytest.approx(3.0, abs=0.01)
    assert flying.kinematics.heading_rad == pytest.approx(1.0, abs=0.01)
    assert flying.height_m == pytest.approx(20.0, abs=0.3)


def test_place_outside_the_fence_is_acknowledged_but_not_flown(flying):
    assert flying.reposition(600, 0, 20) == [ACCEPTED]
    assert flying.texts()[-1] == "Reposition is outside geofence"
    flying.advance(3)
    assert flying.distance_to(0, 0, 20) < 0.3


def test_hold_does_not_stop_a_reposition_but_a_reposition_without_a_place_does(flying):
    flying.reposition(0, 100, 20, speed=5.0)
    flying.advance(4)
    assert flying.long(SET_MODE, 1, 4, 3) == [ACCEPTED, ACCEPTED]
    flying.advance(2)
    assert flying.state.velocity_enu_mps[0, 1] == pytest.approx(5.0, abs=0.01)
    assert flying.long(mavlink.MAV_CMD_DO_REPOSITION, -1, 1, 0, *[math.nan] * 4) == [ACCEPTED]
    flying.advance(4)
    assert abs(flying.state.velocity_enu_mps[0, 1]) < 0.05


def test_lost_link_holds_then_returns_for_good(flying):
    flying.reposition(0, 100, 20, speed=2.0)
    flying.heartbeats_from = None
    flying.advance(12)
    assert mode(flying) == HOLD
    assert flying.texts()[-2] == "Connection to ground station lost"
    assert abs(flying.state.velocity_enu_mps[0, 1]) < 0.5
    flying.advance(5)
    assert mode(flying) == RETURN
    flying.heartbeats_from = 245
    flying.advance(3)
    assert mode(flying) == RETURN


def test_land_disarms_two_seconds_after_touchdown(flying):
    assert flying.long(mavlink.MAV_CMD_NAV_LAND) == [ACCEPTED]
    assert mode(flying) == LAND
    flying.advance_until(lambda: flying.kinematics.on_ground, 30)
    flying.advance(2.5)
    assert flying.autopilot.flight.armed
    flying.advance(1.0)
    assert not flying.autopilot.flight.armed
    assert flying.long(ARM, 1) == [REJECTED], "the mode lands"


def test_critical_battery_holds_then_returns(flying):
    flying.autopilot.battery.consumed_mah = 8600.0
    flying.advance(0.1)
    assert mode(flying) == HOLD
    assert flying.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).system_status == mavlink.MAV_STATE_CRITICAL
    flying.advance(5.1)
    assert mode(flying) == RETURN


def test_a_reposition_cancels_a_failsafe_that_still_holds(flying):
    flying.autopilot.battery.consumed_mah = 8600.0
    flying.advance(1.0)
    assert flying.reposition(10, 20, 25) == [ACCEPTED]
    flying.advance(10.0)
    assert mode(flying) == HOLD
    assert flying.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).system_status == mavlink.MAV_STATE_ACTIVE


def test_integers_travel_bytewise(bench):
    encoded = struct.unpack("<f", struct.pack("<i", 0))[0]
    reply = bench.set_parameter("NAV_DLL_ACT", encoded)
    assert struct.unpack("<i", struct.pack("<f", reply[0].param_value))[0] == 0
    assert reply[0].param_type == mavlink.MAV_PARAM_TYPE_INT32
    assert bench.autopilot.parameters["NAV_DLL_ACT"] == 0


def test_broadcast_is_not_answered(bench):
    assert bench.long(ARM, 1, system=0) == []
    assert bench.long(ARM, 1, system=8) == []
