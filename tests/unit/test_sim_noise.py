"""Errors of poses and of the thermal camera: sizes, and what stays from one exposure to the next."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.noise import (
    GNSS,
    RTK,
    LastingErrors,
    PoseErrors,
    SensorErrors,
    draw_lasting_errors,
    draw_thermal_pattern,
    reported_pose,
)

TRUE = nadir_pose([3.0, -4.0, 38.0], 0.4)
VEHICLES = 4000
STILL = np.zeros(3)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def reports(errors: PoseErrors, velocity_enu_mps: np.ndarray = STILL) -> tuple[np.ndarray, np.ndarray]:
    """Position errors and rotation vectors of one exposure per vehicle, each of shape (VEHICLES, 3)."""
    lasting = draw_lasting_errors(rng(1), errors, VEHICLES)
    draws = rng(2)
    poses = [
        reported_pose(draws, TRUE, errors, lasting, vehicle=i, velocity_enu_mps=velocity_enu_mps)
        for i in range(VEHICLES)
    ]
    shifts_m = np.array([pose.position_enu_m for pose in poses]) - TRUE.position_enu_m
    turns = np.array([pose.R_cam2enu for pose in poses]) @ TRUE.R_cam2enu.T
    return shifts_m, Rotation.from_matrix(turns).as_rotvec()


def test_errors_have_their_deviations() -> None:
    shifts_m, turns_rad = reports(GNSS)
    np.testing.assert_allclose(shifts_m.std(axis=0), [0.5, 0.5, 0.75], rtol=0.06)
    np.testing.assert_allclose(np.degrees(turns_rad.std(axis=0)), [1.0, 1.0, 3.0], rtol=0.06)
    np.testing.assert_allclose(reports(RTK)[0].std(axis=0), [0.02, 0.02, 0.03], rtol=0.06)


def test_only_the_passing_part_averages_out() -> None:
    lasting = draw_lasting_errors(rng(3), GNSS, 1)
    draws = rng(4)
    poses = [reported_pose(draws, TRUE, GNSS, lasting, vehicle=0, velocity_enu_mps=STILL) for _ in range(VEHICLES)]
    shifts_m = np.array([pose.position_enu_m for pose in poses]) - TRUE.position_enu_m
    np.testing.assert_allclose(shifts_m.mean(axis=0), lasting.position_enu_m[0], atol=0.02)
    np.testing.assert_allclose(shifts_m[:, :2].std(axis=0), 0.5 * math.sqrt(0.1), rtol=0.06)


def test_clock_matters_in_flight_only() -> None:
    clock_only = PoseErrors(position_m=0.0, tilt_rad=0.0, yaw_rad=0.0)
    np.testing.assert_array_equal(reports(clock_only)[0], 0.0)
    shifts_m = reports(clock_only, np.array([10.0, 0.0, 0.0]))[0]
    assert shifts_m[:, 0].std() == pytest.approx(0.3, rel=0.06)
    np.testing.assert_array_equal(shifts_m[:, 1:], 0.0)


def test_tilt_moves_the_image_by_its_angle_times_the_height() -> None:
    lasting = LastingErrors(np.zeros((1, 3)), np.array([[0.0, math.radians(1.0), 0.0]]), np.zeros(1))
    errors = replace(GNSS, position_m=0.0, tilt_lasting_share=1.0, yaw_lasting_share=1.0)
    pose: Pose = reported_pose(rng(), TRUE, errors, lasting, vehicle=0, velocity_enu_mps=STILL)
    axis = pose.R_cam2enu[:, 2]
    np.testing.assert_allclose(38.0 * axis[:2] / -axis[2], [-38.0 * math.tan(math.radians(1.0)), 0.0], atol=1e-9)


def test_thermal_pattern_has_an_offset_smooth_shading_and_columns() -> None:
    errors = SensorErrors(offset_k=2.0)
    patterns = np.array([draw_thermal_pattern(rng(seed), errors, (64, 80)) for seed in range(300)])
    assert patterns.dtype == np.float32
    assert patterns.mean(axis=(1, 2)).std() == pytest.approx(2.0, rel=0.15)
    assert np.abs(np.diff(patterns, axis=1)).max() < 0.2
    assert np.diff(patterns, axis=2).std() == pytest.approx(0.05 * math.sqrt(2), rel=0.2)
