"""Rules of the simulated ArduCopter."""

from __future__ import annotations

import dataclasses
import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

ACCEPTED, FAILED, DENIED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_FAILED, mavlink.MAV_RESULT_DENIED
ARM, TAKEOFF, SET_MODE = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_DO_SET_MODE,
)
RESULT_UNSUPPORTED_FRAME = 9
GUIDED, LOITER, RTL, LAND, BRAKE = 4, 5, 6, 9, 17


@pytest.fixture
def bench(make_bench):
    return make_bench("arducopter")


@pytest.fixture
def flying(make_flying):
    """A vehicle in GUIDED, 20 m above home."""
    return make_flying("arducopter")


def mode(bench):
    return bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).custom_mode


def is_armed(bench):
    return bool(bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)


def test_arming_too_early_fails_with_a_reason_and_the_ekf_says_so(make_bench):
    bench = make_bench("arducopter", start_up_s=5.0)
    assert bench.long(ARM, 1) == [FAILED]
    assert bench.texts() == ["Arm: Need Position Estimate"]
    assert bench.request(mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT).flags & 0x98 == 0x80
    assert not bench.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS).onboard_control_sensors_health & (1 << 28)
    assert bench.request(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT).lat == 0
    bench.advance(5.0)
    assert bench.request(mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT).flags & 0x98 == 0x18
    assert bench.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS).onboard_control_sensors_health & (1 << 28)
    assert bench.long(ARM, 1) == [ACCEPTED]
    assert is_armed(bench)


def test_only_the_heartbeat_is_sent_unasked(bench):
    bench.sent.clear()
    bench.advance(10.0)
    kinds = {message.get_type() for message in bench.sent}
    assert kinds == {"HEARTBEAT"}
    assert sum(message.get_srcComponent() == 1 for message in bench.sent) == 10


def test_takeoff_needs_arming_and_guided(bench):
    assert bench.long(TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == [FAILED]
    assert bench.long(ARM, 1) == [ACCEPTED]
    assert bench.long(TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == [FAILED]
    assert bench.long(SET_MODE, 1, GUIDED) == [ACCEPTED]
    assert bench.long(TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == [ACCEPTED]
    bench.advance(20)
    assert bench.height_m == pytest.approx(20.0, abs=0.3)
    assert bench.request(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT).relative_alt == pytest.approx(20_000, abs=300)
    assert bench.request(mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE).landed_state == mavlink.MAV_LANDED_STATE_IN_AIR


def test_armed_without_takeoff_disarms_by_itself(bench):
    bench.long(ARM, 1)
    bench.advance(9.5)
    assert is_armed(bench)
    bench.advance(1.0)
    assert not is_armed(bench)


def test_a_faster_simulation_leaves_as_much_real_time_for_the_takeoff(bench):
    bench.autopilot.identity = dataclasses.replace(bench.autopilot.identity, speed=3.0)
    bench.set_parameter("DISARM_DELAY", 5)
    bench.long(ARM, 1)
    bench.advance(14.5)
    assert is_armed(bench)
    bench.advance(1.0)
    assert not is_armed(bench)


def test_mode_without_position_fails(make_bench):
    bench = make_bench("arducopter", start_up_s=60.0)
    assert bench.long(SET_MODE, 1, GUIDED) == [FAILED]
    assert bench.texts() == ["Mode change to GUIDED failed: requires position"]
    assert bench.long(SET_MODE, 1, 99) == [FAILED]


@pytest.mark.parametrize(
    ("frame", "altitude"),
    [
        (mavlink.MAV_FRAME_GLOBAL_INT, 290.0),
        (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, 30.0),
        (mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT, 30.0),
    ],
)
def test_reposition_flies_to_the_altitude_of_its_frame(flying, frame, altitude):
    assert flying.reposition(20, 30, 30, frame=frame, altitude=altitude) == [ACCEPTED]
    target = flying.request(mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT)
    assert target.alt == pytest.approx(290.0, abs=0.01)
    flying.advance(15)
    assert flying.distance_to(20, 30, 30) < 0.1


def test_reposition_rules(flying):
    place = flying.frame.to_geodetic((5, 5, 20))
    as_long = (-1, 1, 0, 0, place.latitude_deg, place.longitude_deg, place.altitude_amsl_m)
    assert flying.long(mavlink.MAV_CMD_DO_REPOSITION, *as_long) == [mavlink.MAV_RESULT_UNSUPPORTED]
    assert flying.reposition(5, 5, 20, altitude=math.nan) == [DENIED]
    assert flying.reposition(5, 5, 20, frame=mavlink.MAV_FRAME_LOCAL_NED) == [RESULT_UNSUPPORTED_FRAME]
    assert flying.reposition(5, 5, 20, flags=0) == [ACCEPTED], "GUIDED already"
    flying.long(SET_MODE, 1, LOITER)
    assert flying.reposition(5, 5, 20, flags=0) == [DENIED]
    assert flying.reposition(5, 5, 20, flags=1) == [ACCEPTED]
    assert mode(flying) == GUIDED


@pytest.mark.parametrize("place", [(600, 0, 20), (0, 0, 130)])
def test_place_outside_the_fence_is_refused_without_a_text(flying, place):
    texts = flying.texts()
    assert flying.reposition(*place) == [FAILED]
    assert flying.texts() == texts
    flying.advance(3)
    assert flying.distance_to(0, 0, 20) < 0.3
    flying.set_parameter("FENCE_ENABLE", 0)
    assert flying.reposition(*place) == [ACCEPTED]


def test_reposition_on_the_ground_does_not_lift_off(bench):
    bench.long(SET_MODE, 1, GUIDED)
    bench.long(ARM, 1)
    assert bench.reposition(5, 5, 20) == [ACCEPTED]
    bench.advance(3)
    assert bench.height_m == 0.0


def test_speed_of_change_speed_is_flown_in_this_mode_and_that_of_reposition_is_not(flying):
    def speed_mps():
        flying.advance(5)
        return flying.state.velocity_enu_mps[0, 1]

    flying.reposition(0, 300, 20, speed=4.0)
    assert speed_mps() == pytest.approx(10.0, abs=0.01)
    assert flying.long(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 7.0, -1) == [ACCEPTED]
    assert speed_mps() == pytest.approx(7.0, abs=0.01)
    flying.reposition(0, 400, 20)
    assert speed_mps() == pytest.approx(7.0, abs=0.01)
    flying.long(SET_MODE, 1, BRAKE)
    flying.reposition(0, 450, 20)
    assert speed_mps() == pytest.approx(10.0, abs=0.01)
    assert flying.long(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 0.0, -1) == [DENIED]


def test_brake_stops_without_flying_back(flying):
    flying.reposition(0, 200, 20)
    flying.advance(6)
    assert flying.long(SET_MODE, 1, BRAKE) == [ACCEPTED]
    north_m = flying.state.position_enu_m[0, 1]
    for _ in range(60):
        flying.advance(0.1)
        assert flying.state.velocity_enu_mps[0, 1] > -0.05
    assert north_m < flying.state.position_enu_m[0, 1] < north_m + 30
    assert abs(flying.state.velocity_enu_mps[0, 1]) < 0.05


def test_return_climbs_flies_home_lands_and_disarms(flying):
    flying.reposition(40, 40, 20)
    flying.advance(15)
    assert flying.long(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH) == [ACCEPTED]
    assert mode(flying) == RTL
    heights = []
    while is_armed(flying):
        flying.advance(0.5)
        heights.append(flying.height_m)
        away = flying.distance_to(0, 0, flying.height_m) > 1.0
        assert not (flying.height_m < 19.9 and away), "it must not descend before it is home"
        assert len(heights) < 300
    assert max(heights) == pytest.approx(30.0, abs=0.3)
    assert flying.distance_to(0, 0, 0) < 0.3
    assert flying.request(mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE).landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND
    assert flying.long(ARM, 1) == [FAILED], "RTL is not armable"


def test_return_from_a_climb_forward_stays_at_a_return_height_that_leaves_room_to_brake(flying):
    flying.set_parameter("RTL_ALT", 1250.0)
    flying.reposition(0, 0, 5)
    flying.advance(20)
    flying.reposition(0, 100, 30)
    flying.advance(3)
    assert (flying.state.velocity_enu_mps[0, 2], flying.height_m) == pytest.approx((2.5, 8.9), abs=0.2)
    flying.long(SET_MODE, 1, RTL)
    heights = []
    for _ in range(40):
        flying.advance(0.2)
        heights.append(flying.height_m)
    assert max(heights) == pytest.approx(12.5, abs=0.1)


def test_return_from_above_the_return_height_keeps_the_layer(flying):
    flying.reposition(0, 40, 45)
    flying.advance(20)
    flying.long(SET_MODE, 1, RTL)
    flying.advance_until(lambda: flying.distance_to(0, 0, 45) < 1.0, 15)


def test_landing_is_slow_at_the_end(flying):
    assert flying.long(mavlink.MAV_CMD_NAV_LAND) == [ACCEPTED]
    flying.advance(3)
    assert flying.state.velocity_enu_mps[0, 2] == pytest.approx(-1.5, abs=0.05)
    flying.advance_until(lambda: flying.height_m < 8, 10)
    assert flying.state.velocity_enu_mps[0, 2] == pytest.approx(-0.5, abs=0.05)
    flying.advance_until(lambda: not is_armed(flying), 25)
    assert mode(flying) == LAND


def test_wind_does_not_carry_a_landing_away(make_bench):
    bench = make_bench("arducopter", wind_mps=8.0)
    bench.long(SET_MODE, 1, GUIDED)
    bench.long(ARM, 1)
    bench.long(TAKEOFF, 0, 0, 0, 0, 0, 0, 30)
    bench.advance(25)
    assert bench.distance_to(0, 0, 30) < 0.5
    assert abs(bench.request(mavlink.MAVLINK_MSG_ID_ATTITUDE).roll) > 0.02, "it leans into the wind"
    bench.long(mavlink.MAV_CMD_NAV_LAND)
    bench.advance_until(lambda: not is_armed(bench), 60)
    assert bench.distance_to(0, 0, 0) < 1.5


def test_disarming_in_the_air_is_refused_unless_forced(flying):
    assert flying.long(ARM, 0) == [FAILED]
    assert is_armed(flying)
    assert flying.long(ARM, 0, 21196) == [ACCEPTED]
    assert not is_armed(flying)
    flying.advance(3)
    assert flying.height_m == 0.0, "it has fallen"


def test_lost_operator_returns_home_but_only_once_heard(flying):
    flying.advance(20)
    assert mode(flying) == GUIDED, "nobody was ever heard"
    flying.heartbeats_from = 253
    flying.advance(20)
    flying.heartbeats_from = None
    flying.advance(10)
    assert mode(flying) == GUIDED, "253 is not the operator"
    flying.heartbeats_from = 254
    flying.advance(20)
    assert mode(flying) == GUIDED
    flying.heartbeats_from = None
    flying.advance(6.5)
    assert mode(flying) == RTL
    assert flying.texts()[-1] == "GCS Failsafe"


def test_a_faster_simulation_does_not_shorten_the_patience_with_the_link(flying):
    flying.autopilot.identity = dataclasses.replace(flying.autopilot.identity, speed=10.0)
    flying.heartbeat()
    flying.advance(49)
    assert mode(flying) == GUIDED
    flying.advance(2)
    assert mode(flying) == RTL


def test_lost_operator_is_ignored_when_the_failsafe_is_off(flying):
    flying.set_parameter("FS_GCS_ENABLE", 0)
    flying.heartbeat()
    flying.advance(20)
    assert mode(flying) == GUIDED


def test_low_battery_returns_home(flying):
    flying.autopilot.battery.consumed_mah = 8001.0
    flying.advance(0.1)
    assert mode(flying) == RTL
    assert flying.texts()[-1] == "Battery Failsafe"


def test_battery_drains_faster_in_the_air(flying):
    before = flying.autopilot.battery.consumed_mah
    flying.advance(36)
    assert flying.autopilot.battery.consumed_mah - before == pytest.approx(200, rel=0.01)
    status = flying.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS)
    assert status.battery_remaining < 100
    assert 20_000 < status.voltage_battery < 25_200


def test_integers_are_cast_and_unknown_parameters_ignored(bench):
    reply = bench.set_parameter("RTL_ALT", 4200.0)
    assert [(m.param_id, m.param_value, m.param_type) for m in reply] == [("RTL_ALT", 4200.0, 6)]
    assert bench.autopilot.flight.settings.return_height_m == 42.0
    assert bench.set_parameter("NO_SUCH", 1.0) == []


def test_broadcast_is_accepted_and_other_systems_ignored(bench):
    assert bench.long(SET_MODE, 1, GUIDED, system=8) == []
    assert bench.long(SET_MODE, 1, GUIDED, system=0) == [ACCEPTED]
    assert bench.long(4242) == [mavlink.MAV_RESULT_UNSUPPORTED]
