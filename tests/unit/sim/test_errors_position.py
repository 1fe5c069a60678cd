"""Errors of positions and attitudes: seeded, as large as they are reported, and in what telemetry says."""

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.telemetry import Telemetry
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.model import GNSS, NONE, RTK
from aos_sim.errors.position import PositionErrors, PositionProcess
from aos_sim.vehicle.dynamics import SwarmState
from aos_sim.vehicle.kinematics import read_kinematics

FRAME = LocalFrame(GeodeticPosition(48.3, 14.3, 260.0))


@pytest.mark.parametrize("sizes", [RTK.position, GNSS.position])
def test_errors_are_as_large_as_the_receivers_report(sizes: PositionErrors) -> None:
    process = PositionProcess(sizes, 4000, seed=1)
    for _ in range(3):
        process.advance(1.0)
    horizontal_m, vertical_m = sizes.accuracy_m
    assert np.std(process.estimate_enu_m, axis=0) == pytest.approx([horizontal_m, horizontal_m, vertical_m], rel=0.1)
    assert np.std(process.receiver_enu_m[:, 2]) == pytest.approx(vertical_m, rel=0.1)


def test_errors_drift_slowly_about_a_constant_and_are_seeded() -> None:
    processes = [PositionProcess(GNSS.position, 2000, seed) for seed in (1, 1, 2)]
    for process in processes:
        process.advance(0.2)
    first, same, other = (process.estimate_enu_m[:, 2] for process in processes)
    assert np.array_equal(first, same)
    assert not np.array_equal(first, other)
    for _ in range(10):
        processes[0].advance(100.0)
    later = processes[0].estimate_enu_m[:, 2]
    # Only the constant part is left in common.
    assert np.corrcoef(first, later)[0, 1] == pytest.approx(1.5**2 / (1.5**2 + 1.0), abs=0.05)


def test_an_autopilot_does_not_shake_its_vehicle_by_the_noise_of_its_position() -> None:
    process = PositionProcess(GNSS.position, 50, seed=1)
    changes_m, far_m = [], []
    for _ in range(200):
        before_m = process.steered_enu_m
        process.advance(0.1)
        changes_m.append(process.steered_enu_m - before_m)
        far_m.append(process.steered_enu_m - process.estimate_enu_m)
    # Noise and drift of the estimate differ by 4 cm from one tenth of a second to the next.
    assert np.std(changes_m) < 0.01
    assert np.std(far_m) < 0.15
    exact = PositionProcess(RTK.position, 50, seed=1)
    exact.advance(0.1)
    assert np.array_equal(exact.steered_enu_m, exact.estimate_enu_m)


def test_an_estimate_can_run_away_from_the_true_height() -> None:
    process = PositionProcess(RTK.position, 2, seed=1)
    process.climb_mps[1] = 0.1
    for _ in range(100):
        process.advance(1.0)
    assert process.estimate_enu_m[:, 2] == pytest.approx([0.0, 10.0], abs=0.2)


def test_autopilot_believes_its_estimate_and_cameras_see_from_the_true_place() -> None:
    state = SwarmState.at_rest(np.zeros((3, 3)), np.zeros(3))
    process = PositionProcess(GNSS.position, 3, seed=4)
    kinematics = read_kinematics(state, FRAME, process)
    assert [each.true_enu_m for each in kinematics] == [(0.0, 0.0, 0.0)] * 3
    assert np.array([each.position_enu_m for each in kinematics]) == pytest.approx(process.estimate_enu_m)
    assert [each.heading_rad for each in kinematics] == [0.0] * 3
    measured_m = [FRAME.to_enu(each.receiver_geodetic)[2] for each in kinematics]
    assert measured_m == pytest.approx(process.receiver_enu_m[:, 2], abs=1e-6)


def test_attitudes_are_believed_with_their_errors_and_told_as_they_are() -> None:
    state = SwarmState.at_rest(np.zeros((3, 3)), np.full(3, 6.2))
    attitudes = AttitudeProcess(RTK.attitude, 3, seed=4)
    kinematics = read_kinematics(state, FRAME, None, attitudes)
    believed_rad = np.array([[each.roll_rad, each.pitch_rad, each.heading_rad] for each in kinematics])
    errors_rad = attitudes.estimate_rad + np.array([0.0, 0.0, 6.2])
    np.testing.assert_allclose(believed_rad[:, :2], errors_rad[:, :2])
    np.testing.assert_allclose(believed_rad[:, 2], errors_rad[:, 2] % (2 * np.pi))
    assert [each.true_attitude_rad for each in kinematics] == [(0.0, 0.0, 6.2)] * 3


def test_without_errors_a_vehicle_believes_the_truth() -> None:
    state = SwarmState.at_rest(np.ones((2, 3)), np.array([0.0, 2.0]))
    process = PositionProcess(NONE.position, 2, seed=1)
    process.advance(10.0)
    for exact in read_kinematics(state, FRAME, process, AttitudeProcess(NONE.attitude, 2, seed=1)):
        assert exact.position_enu_m == exact.true_enu_m
        assert (exact.roll_rad, exact.pitch_rad, exact.heading_rad) == exact.true_attitude_rad


def test_driver_reads_accuracies_receiver_altitude_and_pressure() -> None:
    telemetry = Telemetry()
    gps = {"lat": 483000000, "lon": 143000000, "alt": 260500, "eph": 80, "epv": 90, "vel": 0, "cog": 0}
    gps |= {"satellites_visible": 14, "fix_type": 6, "time_usec": 0}
    telemetry.update(mavlink.MAVLink_gps_raw_int_message(**gps, h_acc=900, v_acc=1500), 0.0)
    telemetry.update(mavlink.MAVLink_scaled_pressure_message(0, 981.5, 0.0, 2500), 0.0)
    assert (telemetry.horizontal_accuracy_m, telemetry.vertical_accuracy_m) == (0.9, 1.5)
    assert (telemetry.gps_altitude_amsl_m, telemetry.pressure_hpa) == (260.5, 981.5)
    ratios = (0.1, 0.1, 0.7, 0.1, 0.0, 0.0)
    telemetry.update(mavlink.MAVLink_estimator_status_message(0, 0x33F, *ratios, 0.4, 2.5), 0.0)
    assert (telemetry.horizontal_accuracy_m, telemetry.vertical_accuracy_m) == (0.9, 2.5)
    assert telemetry.altitude_test_ratio == pytest.approx(0.7)
    # A packet of MAVLink 1 says nothing of accuracies.
    telemetry.update(mavlink.MAVLink_gps_raw_int_message(**gps), 0.0)
    assert telemetry.vertical_accuracy_m == 2.5
    telemetry.update(mavlink.MAVLink_ekf_status_report_message(0x33F, 0.1, 0.1, 0.9, 0.1, 0.0), 0.0)
    assert telemetry.altitude_test_ratio == pytest.approx(0.9)


@pytest.mark.parametrize(
    "loss",
    [
        mavlink.MAVLink_gps_raw_int_message(0, 1, 0, 0, 0, 65535, 65535, 0, 0, 0),
        mavlink.MAVLink_ekf_status_report_message(0xA5, 0.1, 0.1, 0.1, 0.1, 0.0),
        mavlink.MAVLink_estimator_status_message(0, 0xA5, 0.1, 0.1, 0.1, 0.1, 0.0, 0.0, 100.0, 100.0),
    ],
    ids=["fix", "ArduPilot's estimator", "PX4's estimator"],
)
def test_positions_that_are_repeated_after_a_loss_keep_their_age(loss: mavlink.MAVLink_message) -> None:
    telemetry = Telemetry()
    report = mavlink.MAVLink_global_position_int_message(0, 483000000, 143000000, 294800, 34800, 0, 0, 0, 0)
    telemetry.update(report, 1.0)
    assert telemetry.position_at_s == 1.0
    telemetry.update(loss, 1.5)
    for now_s in (2.0, 5.0, 11.0):
        telemetry.update(report, now_s)
    assert telemetry.position_at_s == 1.0
