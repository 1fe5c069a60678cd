"""The simulator's error model: sizes, correlation times, equal draws from equal seeds, and refusals."""

import math
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.exposure import CameraErrors, Motion
from aos_sim.errors.hover import Hover
from aos_sim.errors.model import GNSS, GRADES, NONE, RTK, ErrorModel, error_model
from aos_sim.errors.optics import OpticsErrors, blurred, lagged, smeared
from aos_sim.errors.position import PositionErrors, PositionProcess
from aos_sim.errors.sensor import CameraSensor
from aos_sim.errors.sizes import drifted
from aos_sim.errors.thermal import ThermalErrors, draw_thermal_pattern, thermal_drift_k
from aos_sim.errors.timing import TimingErrors

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
KINDS = ("position", "attitude", "gimbal", "timing", "wind", "thermal", "optics")
DOCUMENT = Path(__file__).parents[3] / "docs" / "simulator.md"
SHAPE = (48, 64)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def shown(name: str, value: object) -> str:
    """Return a value as the document shows it."""
    if isinstance(value, tuple):
        return ", ".join(shown(name, part) for part in value)
    if name.endswith("_rad") and isinstance(value, float):
        return f"{math.degrees(value):.3g}°"
    return "the true ones" if value is None else f"{value:g}"


# --- drift ---------------------------------------------------------------------------------------------------------


@given(
    size=st.floats(0.01, 10.0),
    duration_s=st.floats(0.01, 1000.0),
    correlation_s=st.floats(0.1, 300.0),
    seed=st.integers(0, 1000),
)
def test_a_drift_keeps_its_size_and_forgets_at_its_rate(
    size: float, duration_s: float, correlation_s: float, seed: int
) -> None:
    draws = rng(seed)
    before = draws.standard_normal(20_000) * size
    after = drifted(draws, before, size, duration_s, correlation_s)
    assert after.std() == pytest.approx(size, rel=0.05)
    expected = math.exp(-duration_s / correlation_s)
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(expected, abs=0.04)


def test_a_drift_in_many_steps_is_the_one_in_one_step() -> None:
    state = start = rng(1).standard_normal(50_000)
    for _ in range(10):
        state = drifted(rng(int(1e6 * state[0]) % 2**32), state, 1.0, 3.0, 30.0)
    assert np.corrcoef(start, state)[0, 1] == pytest.approx(math.exp(-1.0), abs=0.02)


def test_white_noise_of_positions_is_new_in_every_step() -> None:
    process = PositionProcess(PositionErrors(white_m=(0.1, 0.2)), 20_000, seed=3)
    before = process.estimate_enu_m
    process.advance(0.1)
    assert before.std(axis=0) == pytest.approx([0.1, 0.1, 0.2], rel=0.05)
    assert abs(np.corrcoef(before[:, 0], process.estimate_enu_m[:, 0])[0, 1]) < 0.03
    assert process.sizes.accuracy_m == (0.1, 0.2)


def test_attitudes_err_by_their_sizes_and_drift() -> None:
    process = AttitudeProcess(RTK.attitude, 20_000, seed=1)
    before_rad = process.estimate_rad
    tilt_rad, heading_rad = math.hypot(0.7, 0.3), math.hypot(2.9, 0.7)
    assert np.degrees(before_rad.std(axis=0)) == pytest.approx([tilt_rad, tilt_rad, heading_rad], rel=0.05)
    process.advance(3600.0)
    correlation = np.corrcoef(before_rad[:, 2], process.estimate_rad[:, 2])[0, 1]
    assert correlation == pytest.approx(2.9**2 / heading_rad**2, abs=0.02)


# --- exposures -----------------------------------------------------------------------------------------------------


def test_without_errors_a_camera_looks_straight_down_from_where_its_vehicle_is() -> None:
    motion = Motion(np.array([3.0, -4.0, 38.0]), 0.4, np.array([8.0, 1.0, 0.5]), (0.1, 0.2, 0.3))
    exact = CameraErrors(NONE.gimbal, NONE.timing, 1).expose(7, 3, motion, CAMERA)
    pose = nadir_pose(motion.position_enu_m, 0.4)
    np.testing.assert_array_equal(exact.pose.position_enu_m, pose.position_enu_m)
    np.testing.assert_allclose(exact.pose.R_cam2enu, pose.R_cam2enu, atol=1e-12)


def test_gimbals_err_by_their_sizes_and_partly_for_good() -> None:
    cameras = CameraErrors(RTK.gimbal, TimingErrors(), 5)
    level = nadir_pose([0.0, 0.0, 40.0], 1.0).R_cam2enu
    still = Motion(np.array([0.0, 0.0, 40.0]), 1.0, np.zeros(3))
    turns = np.array(
        [
            [level.T @ cameras.expose(camera_id, index, still, CAMERA).pose.R_cam2enu for index in range(4)]
            for camera_id in range(1500)
        ]
    )
    angles = np.degrees(Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(1500, 4, 3))
    assert angles.mean(axis=1).std(axis=0) == pytest.approx([0.7, 0.7, 0.5], rel=0.06)
    assert (angles - angles.mean(axis=1, keepdims=True)).std() == pytest.approx(0.1 * math.sqrt(3 / 4), rel=0.06)


def test_a_gimbal_lets_through_fast_turns() -> None:
    gimbal = replace(NONE.gimbal, lag_s=0.1)
    turning = Motion(np.array([0.0, 0.0, 40.0]), 0.0, np.zeros(3), (0.0, 0.0, 0.5))
    pose = CameraErrors(gimbal, TimingErrors(), 1).expose(1, 0, turning, CAMERA).pose
    np.testing.assert_allclose(pose.R_cam2enu, nadir_pose([0, 0, 40], -0.05).R_cam2enu, atol=1e-9)


def test_late_shutters_matter_in_flight_only() -> None:
    cameras = CameraErrors(NONE.gimbal, RTK.timing, 2)
    place = np.array([0.0, 0.0, 40.0])
    still, flying = (Motion(place, 0.0, np.array([speed, 0.0, 0.0])) for speed in (0.0, 10.0))
    at_rest = [cameras.expose(camera_id, 0, still, CAMERA).pose.position_enu_m for camera_id in range(50)]
    np.testing.assert_array_equal(at_rest, np.broadcast_to(place, (50, 3)))
    shifts_m = [cameras.expose(camera_id, 0, flying, CAMERA).pose.position_enu_m[0] for camera_id in range(3000)]
    assert np.mean(shifts_m) == pytest.approx(0.3, abs=0.03)
    assert np.std(shifts_m) == pytest.approx(10.0 * math.hypot(0.03, 0.01), rel=0.06)


def test_motion_moves_the_image_against_the_flight() -> None:
    north = Motion(np.array([0.0, 0.0, 40.0]), 0.0, np.array([0.0, 8.0, 0.0]))
    right, down = CameraErrors(NONE.gimbal, NONE.timing, 1).expose(1, 0, north, CAMERA).speed_pxps
    assert (right, down) == pytest.approx((0.0, 8.0 * CAMERA.fy_px / 40.0), abs=1e-9)


# --- sensors -------------------------------------------------------------------------------------------------------


def test_a_thermal_pattern_has_an_offset_shading_columns_and_pixels() -> None:
    errors = ThermalErrors(offset_k=2.0, shading_k=0.3, column_k=0.05, pixel_k=0.02)
    patterns = np.array([draw_thermal_pattern(rng(seed), errors, (64, 80)) for seed in range(300)])
    assert patterns.dtype == np.float32
    assert patterns.mean(axis=(1, 2)).std() == pytest.approx(2.0, rel=0.15)
    assert np.diff(patterns, axis=2).std() == pytest.approx(math.sqrt(2 * (0.05**2 + 0.02**2)), rel=0.2)
    only_shading = draw_thermal_pattern(rng(), ThermalErrors(shading_k=0.3), (64, 80))
    assert np.abs(np.diff(only_shading, axis=0)).max() < 0.15


def test_offsets_drift_from_one_calibration_to_the_next_and_jump_there() -> None:
    errors = ThermalErrors(nuc_period_s=100.0, nuc_step_k=0.5, drift_k_per_min=0.6)
    offsets_k = np.array([[thermal_drift_k(errors, (1, camera), t) for t in range(0, 400, 2)] for camera in range(80)])
    speeds = np.diff(offsets_k, axis=1) / 2.0
    is_jump = np.abs(np.diff(speeds, axis=1)) > 1e-9
    # Each calibration changes two differences of speed: into the jump, and out of it.
    assert set(is_jump.sum(axis=1)) <= {6, 7, 8}
    assert np.median(np.abs(speeds)) == pytest.approx(0.6745 * 0.01, rel=0.2)
    assert offsets_k.std() == pytest.approx(math.hypot(0.5, 0.6 * (100 / 60) / math.sqrt(3)), rel=0.2)


def test_noise_has_its_size_and_comes_from_its_generator() -> None:
    sensor = CameraSensor(NONE.thermal, NONE.optics)
    grey = np.full((*SHAPE, 4), 100.0, np.float32)
    first, same, other = (sensor.expose(grey, rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.thermal_celsius, same.thermal_celsius)
    np.testing.assert_array_equal(first.rgb, same.rgb)
    assert not np.array_equal(first.thermal_celsius, other.thermal_celsius)
    assert first.thermal_celsius.std() == pytest.approx(0.08, rel=0.06)
    assert first.rgb.std() == pytest.approx(2.0, rel=0.06)


def test_no_errors_leave_a_view_as_it_is_but_for_noise() -> None:
    view = rng(3).uniform(20.0, 200.0, (*SHAPE, 4)).astype(np.float32)
    noise = rng(9).standard_normal((*SHAPE, 4), dtype=np.float32) * np.array([2.0, 2.0, 2.0, 0.08], np.float32)
    frame = CameraSensor(NONE.thermal, NONE.optics).expose(
        view, rng(9), camera_id=3, at_s=77.0, speed_pxps=(900.0, 0.0)
    )
    np.testing.assert_array_equal(frame.thermal_celsius, (view + noise)[..., 3])
    np.testing.assert_array_equal(frame.rgb, np.rint(np.clip((view + noise)[..., :3], 0, 255)).astype(np.uint8))


def test_patterns_stay_with_a_camera_and_differ_between_cameras() -> None:
    sensor = CameraSensor(replace(RTK.thermal, netd_k=0.0), RTK.optics, seed=5)
    flat = np.full((*SHAPE, 4), 12.0, np.float32)
    first, again, other = (
        sensor.expose(flat, rng(seed), camera_id=camera).thermal_celsius for seed, camera in ((1, 1), (2, 1), (1, 2))
    )
    np.testing.assert_array_equal(first, again)
    assert abs(float(np.mean(first - other))) > 0.05
    assert CameraSensor(RTK.thermal, RTK.optics, seed=5).expose(flat, rng(1)).thermal_celsius.shape == SHAPE


@given(deviation_px=st.floats(0.3, 3.0))
def test_blur_keeps_the_sum_and_spreads_a_point_by_its_deviation(deviation_px: float) -> None:
    point = np.zeros((41, 41), np.float32)
    point[20, 20] = 1.0
    spread = blurred(point, deviation_px)
    assert spread.sum() == pytest.approx(1.0, abs=1e-4)
    columns = np.arange(41) - 20
    variance = float((spread.sum(axis=0) * columns**2).sum())
    # A sampled Gaussian of less than half a pixel is narrower than the true one.
    assert variance <= deviation_px**2 * 1.01
    if deviation_px > 0.6:
        assert variance == pytest.approx(deviation_px**2, rel=0.05)


def test_motion_smears_along_itself() -> None:
    point = np.zeros((41, 41), np.float32)
    point[20, 20] = 1.0
    smear = smeared(point, (6.0, 0.0))
    assert smear.sum() == pytest.approx(1.0, abs=1e-4)
    assert np.count_nonzero(smear[20] > 0.05) == pytest.approx(7, abs=1)
    assert smear[18:20].max() < 0.01
    trail = lagged(point, (2.0, 0.0))[20]
    # The image moves to the right; where it was shortly before is left of it, and fades.
    assert trail[20] > trail[18] > trail[16] > 0.0
    assert trail[22] == pytest.approx(0.0, abs=1e-6)
    assert smeared(point, (0.1, 0.1)) is point


def test_corners_are_darker_and_files_lose_detail() -> None:
    bright = np.full((*SHAPE, 4), 200.0, np.float32)
    vignetted = CameraSensor(NONE.thermal, OpticsErrors(vignetting=0.3)).expose(bright, rng()).rgb
    assert vignetted[0, 0].tolist() == [140, 140, 140]
    assert vignetted[24, 32].tolist() == [200, 200, 200]
    busy = rng(1).uniform(0.0, 255.0, (*SHAPE, 4)).astype(np.float32)
    plain, small = (CameraSensor(NONE.thermal, OpticsErrors(jpeg_quality=q)).expose(busy, rng()).rgb for q in (0, 50))
    assert plain.shape == small.shape
    assert 5.0 < np.abs(plain.astype(int) - small.astype(int)).mean() < 80.0
    red = np.zeros((*SHAPE, 4), np.float32)
    red[..., 0] = 200.0
    assert CameraSensor(NONE.thermal, OpticsErrors(jpeg_quality=95)).expose(red, rng()).rgb[10, 10, 0] > 190


# --- hovering ------------------------------------------------------------------------------------------------------


def test_hovering_vehicles_report_where_they_believe_to_be() -> None:
    hover = Hover(GNSS, 3, seed=2)
    waypoint = np.array([5.0, 6.0, 36.0])
    true = hover.motion(1, waypoint, 0.3, rng())
    reported = hover.reported(1, true)
    np.testing.assert_allclose(reported.position_enu_m, waypoint)
    np.testing.assert_allclose(reported.R_cam2enu, nadir_pose(waypoint, 0.3).R_cam2enu, atol=1e-12)
    assert np.linalg.norm(true.position_enu_m - waypoint) > 0.05
    better = Hover(RTK, 3, seed=2).reported(1, true)
    assert not np.allclose(better.position_enu_m, waypoint, atol=0.05)
    assert np.linalg.norm(better.position_enu_m - true.position_enu_m) < 0.15


# --- grades --------------------------------------------------------------------------------------------------------


def test_grades_by_name() -> None:
    assert [error_model(name) for name in ("none", "rtk", "gnss")] == [NONE, RTK, GNSS]
    with pytest.raises(ConfigurationError, match=r"--errors must be one of none, rtk, gnss, got 'exact'"):
        error_model("exact")
    assert RTK.with_wind(None) is RTK
    assert RTK.with_wind(8.0).wind.mean_enu_mps == pytest.approx((8.0, 0.0, 0.0))
    with pytest.raises(ConfigurationError, match=r"wind\.mean_mps must be 0 or more, got -1"):
        RTK.with_wind(-1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_negative_sizes_are_refused_by_name(kind: str) -> None:
    errors = getattr(RTK, kind)
    for field in fields(errors):
        value = getattr(errors, field.name)
        for bad in (-1.0, math.nan, math.inf):
            worse = (value[0], bad) if isinstance(value, tuple) else bad
            with pytest.raises(ConfigurationError, match=rf"^{kind}\.{field.name} must be "):
                replace(errors, **{field.name: worse})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vignetting": 1.5}, "optics.vignetting must be at most 1"),
        ({"jpeg_quality": 101}, "optics.jpeg_quality must be at most 100"),
    ],
)
def test_shares_and_qualities_have_a_maximum(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        replace(RTK.optics, **changes)


def test_correlation_times_of_zero_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"position\.drift_s must be above 0, got 0"):
        PositionErrors(drift_s=0.0)


def test_the_document_names_every_parameter_with_its_values_and_source() -> None:
    rows = {
        cells[0].strip("`"): cells[1:]
        for line in DOCUMENT.read_text(encoding="utf-8").splitlines()
        if (cells := [cell.strip() for cell in line.strip("|").split("|")]) and re.fullmatch(r"`\w+\.\w+`", cells[0])
    }
    assert set(KINDS) == {field.name for field in fields(ErrorModel)}
    for kind in KINDS:
        for field in fields(getattr(RTK, kind)):
            name = f"{kind}.{field.name}"
            values = [shown(field.name, getattr(getattr(model, kind), field.name)) for model in GRADES.values()]
            assert rows[name][:3] == values, name
            assert rows.pop(name)[4], f"{name} has no source"
    assert not rows
