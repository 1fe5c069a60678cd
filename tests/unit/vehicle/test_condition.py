"""What vehicles report of their own sensors, as the drivers understand it."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.arducopter import ArduCopterDialect
from aos_drivers.vehicle.autopilots.px4 import Px4Dialect
from aos_drivers.vehicle.telemetry import Telemetry

GOOD = mavlink.EKF_ATTITUDE | mavlink.EKF_POS_HORIZ_REL | mavlink.EKF_POS_HORIZ_ABS


def copter(flags: int, velocity: float = 0.1, position: float = 0.1) -> str:
    telemetry = Telemetry()
    telemetry.update(mavlink.MAVLink_ekf_status_report_message(flags, velocity, position, 0.1, 0.1, 0.1), 1.0)
    return ArduCopterDialect().estimator_problem(telemetry)


def px4(flags: int, velocity: float = 0.1, position: float = 0.1) -> str:
    telemetry = Telemetry()
    message = mavlink.MAVLink_estimator_status_message(0, flags, velocity, position, 0.1, 0.1, 0.1, 0.1, 0.3, 0.3)
    telemetry.update(message, 1.0)
    return Px4Dialect().estimator_problem(telemetry)


@pytest.mark.parametrize("problem_of", [copter, px4])
def test_an_estimator_without_position_or_with_deviations_is_a_problem(problem_of) -> None:
    assert problem_of(GOOD) == ""
    assert problem_of(mavlink.EKF_ATTITUDE) == "its estimator has no position"
    assert problem_of(GOOD, velocity=1.4) == "its position deviates from its sensors (1.4 of 1.0)"
    assert problem_of(GOOD, position=1.2) == "its position deviates from its sensors (1.2 of 1.0)"
    assert problem_of(GOOD, position=float("nan")) == ""


def test_constant_positions_are_no_positions() -> None:
    assert copter(GOOD | mavlink.EKF_CONST_POS_MODE) == "its estimator has no position"


def test_a_battery_is_as_old_as_its_last_valid_report() -> None:
    telemetry = Telemetry()
    assert telemetry.battery_at_s is None
    telemetry.update(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 15_800, -1, 83, 0, 0, 0, 0, 0, 0), 1.0)
    assert (telemetry.battery_fraction, telemetry.battery_at_s) == (0.83, 1.0)
    telemetry.update(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 15_800, -1, -1, 0, 0, 0, 0, 0, 0), 2.0)
    assert (telemetry.battery_fraction, telemetry.battery_at_s) == (0.83, 1.0)
    telemetry.update(mavlink.MAVLink_battery_status_message(0, 0, 0, 0, [0] * 10, -1, -1, -1, 82), 3.0)
    assert (telemetry.battery_fraction, telemetry.battery_at_s) == (0.82, 3.0)


def test_the_largest_level_of_vibration_counts() -> None:
    telemetry = Telemetry()
    telemetry.update(mavlink.MAVLink_vibration_message(0, 3.0, 41.0, 8.0, 0, 0, 0), 1.0)
    assert telemetry.vibration_mps2 == 41.0


def test_px4_is_asked_for_its_vibration() -> None:
    assert Px4Dialect().stream_rates_hz(5.0)[mavlink.MAVLINK_MSG_ID_VIBRATION] > 0.0
