"""Poses at the time of exposure: interpolation, gimbals, mounts and clocks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_drivers.frames.errors import FrameRefusedError
from aos_drivers.frames.poses.clocks import BootClock, LeastDelay, unwrap_us, utc_s_of
from aos_drivers.frames.poses.gimbal import (
    YAW_IN_EARTH_FRAME,
    YAW_IN_VEHICLE_FRAME,
    YAW_LOCK,
    gimbal_attitude,
    heading_of,
)
from aos_drivers.frames.poses.mount import CameraMount, Carrier, camera_pose
from aos_drivers.frames.poses.plausibility import check_pose, check_quaternion
from aos_drivers.frames.poses.track import KEPT_S, Motion, PoseTrack, Samples, slerp
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import nadir_pose

HOME = GeodeticPosition(48.3, 14.3, 260.0)
FRAME = LocalFrame(HOME)
ANGLES = st.floats(-3.0, 3.0)


def rotation(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    return Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()


def angles(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> tuple[float, float, float]:
    return yaw, pitch, roll


def quaternion(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    return Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat(scalar_first=True)


def motion(position: GeodeticPosition, velocity_enu_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Motion:
    return (position.latitude_deg, position.longitude_deg, position.altitude_amsl_m, *velocity_enu_mps)


def circling(times_s: np.ndarray, yaw_rate: float = 0.5) -> PoseTrack:
    """A vehicle on a circle of 10 m that looks along its way."""
    track = PoseTrack()
    for at_s in times_s:
        angle = yaw_rate * at_s
        place = FRAME.to_geodetic((10.0 * math.sin(angle), 10.0 * math.cos(angle), 30.0))
        speed = 10.0 * yaw_rate
        track.add_motion(at_s, motion(place, (speed * math.cos(angle), -speed * math.sin(angle), 0.0)))
        track.add_attitude(at_s, angles(angle + math.pi / 2, roll=0.1 * math.sin(angle)))
    return track


# --- interpolation ---------------------------------------------------------------------------------------------------


@given(st.floats(0.0, 1.0), ANGLES, ANGLES, st.floats(-1.5, 1.5))
def test_slerp_turns_evenly_about_one_axis(share: float, yaw: float, start_yaw: float, pitch: float) -> None:
    start = rotation(start_yaw, pitch)
    end = start @ Rotation.from_rotvec([0.3 * yaw, -0.2 * yaw, 0.4 * yaw]).as_matrix()
    whole = Rotation.from_matrix(start.T @ end).magnitude()
    part = Rotation.from_matrix(start.T @ slerp(share, start, end)).magnitude()
    assert part == pytest.approx(share * whole, abs=1e-7)


@settings(max_examples=25)
@given(st.floats(1.0, 8.9))
def test_positions_between_reports_follow_the_curve_and_not_the_chord(at_s: float) -> None:
    track = circling(np.arange(0.0, 10.0, 0.5))
    angle = 0.5 * at_s
    east_m, north_m, up_m = FRAME.to_enu(track.position_at(at_s, 1.0))
    # Chords of half a second would be off by up to 10 m * (1 - cos(0.125)) = 0.078 m.
    assert math.hypot(east_m - 10.0 * math.sin(angle), north_m - 10.0 * math.cos(angle)) < 2e-3
    assert up_m == pytest.approx(30.0, abs=1e-4)
    assert heading_of(track.R_body2ned_at(at_s, 1.0)) % math.tau == pytest.approx(
        (angle + math.pi / 2) % math.tau, abs=2e-3
    )


def test_past_the_latest_report_a_vehicle_goes_on_until_the_limit() -> None:
    track = circling(np.array([0.0, 0.5]), yaw_rate=0.0)
    track.add_motion(1.0, motion(FRAME.to_geodetic((0, 10, 30)), (4.0, 0.0, -1.0)))
    assert FRAME.to_enu(track.position_at(1.4, 0.5)) == pytest.approx([1.6, 10.0, 29.6], abs=1e-3)
    assert not track.covers(1.0)
    assert track.covers(0.5)
    with pytest.raises(FrameRefusedError, match=r"0\.60 s older.*0\.5 s \(max_pose_age_s\)"):
        track.position_at(1.6, 0.5)


def test_a_gap_and_silence_are_told_apart() -> None:
    track = PoseTrack()
    with pytest.raises(FrameRefusedError, match="reports no position"):
        track.position_at(1.0, 1.0)
    with pytest.raises(FrameRefusedError, match="reports no gimbal attitude"):
        track.R_gimbal2ned_at(1.0, 1.0)
    for at_s in (0.0, 10.0):
        track.add_attitude(at_s, angles(0.0))
    with pytest.raises(FrameRefusedError, match="gap"):
        track.R_body2ned_at(5.0, 1.0)


def test_samples_are_bounded_late_ones_dropped_and_a_restart_clears() -> None:
    samples: Samples[int] = Samples()
    for index in range(4000):
        samples.add(index * 0.01, index)
    assert samples.latest_s == pytest.approx(39.99)
    assert len(samples) <= 1024
    assert samples.around(39.99 - KEPT_S - 1.0, 0.1) is None
    samples.add(39.5, -1)
    assert -1 not in samples.values
    samples.add(3.0, -2)
    assert list(samples.values) == [-2]


# --- gimbals ---------------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(yaw=ANGLES, pitch=st.floats(-1.5, 1.5), heading=ANGLES)
def test_every_form_of_a_gimbals_attitude_is_the_same_rotation(yaw: float, pitch: float, heading: float) -> None:
    """``yaw`` is relative to the vehicle; the expectation is relative to north."""
    expected = rotation(heading + yaw, pitch)
    in_vehicle, in_earth = quaternion(yaw, pitch), quaternion(heading + yaw, pitch)
    forms = [
        (in_vehicle, YAW_IN_VEHICLE_FRAME, heading),
        (in_vehicle, YAW_IN_VEHICLE_FRAME, math.nan),
        (in_vehicle, YAW_IN_VEHICLE_FRAME | YAW_LOCK, heading),
        (in_earth, YAW_IN_EARTH_FRAME, heading),
        (in_earth, YAW_IN_EARTH_FRAME, math.nan),
        (in_earth, YAW_LOCK, 99.0),
        (in_vehicle, 0, 99.0),
    ]
    for q_wxyz, flags, delta_yaw in forms:
        track = PoseTrack()
        track.add_attitude(0.0, angles(heading, roll=0.2))
        track.add_gimbal(0.0, gimbal_attitude(q_wxyz, flags, delta_yaw))
        assert track.R_gimbal2ned_at(0.0, 1.0) == pytest.approx(expected, abs=1e-9)


def test_a_gimbal_that_follows_the_heading_turns_with_the_vehicle_between_its_reports() -> None:
    track = PoseTrack()
    for at_s in (0.0, 0.5, 1.0):
        track.add_attitude(at_s, angles(at_s))
    for at_s in (0.0, 1.0):
        track.add_gimbal(at_s, gimbal_attitude(quaternion(0.0, -1.0), YAW_IN_VEHICLE_FRAME, math.nan))
    assert track.R_gimbal2ned_at(0.25, 0.5) == pytest.approx(rotation(0.25, -1.0), abs=1e-9)


def test_a_gimbal_that_changes_its_frame_starts_anew() -> None:
    track = PoseTrack()
    track.add_gimbal(0.0, gimbal_attitude(quaternion(1.0), YAW_IN_VEHICLE_FRAME, math.nan))
    track.add_gimbal(1.0, gimbal_attitude(quaternion(2.0), YAW_IN_EARTH_FRAME, math.nan))
    assert track.R_gimbal2ned_at(1.0, 0.1) == pytest.approx(rotation(2.0))
    with pytest.raises(FrameRefusedError):
        track.R_gimbal2ned_at(0.0, 0.1)


def test_both_frames_at_once_are_forbidden() -> None:
    with pytest.raises(ValueError, match="at once"):
        gimbal_attitude([1.0, 0.0, 0.0, 0.0], YAW_IN_EARTH_FRAME | YAW_IN_VEHICLE_FRAME, 0.0)


# --- mounts ----------------------------------------------------------------------------------------------------------


@given(ANGLES)
def test_a_camera_below_a_level_vehicle_looks_down_with_its_upper_edge_forward(heading: float) -> None:
    track = PoseTrack()
    track.add_motion(0.0, motion(HOME))
    track.add_attitude(0.0, angles(heading))
    expected = nadir_pose([0, 0, 0], heading).R_cam2enu
    for mount in (CameraMount(), CameraMount(Carrier.LEVEL)):
        assert camera_pose(track, mount, 0.0, 0.1)[1] == pytest.approx(expected, abs=1e-9)


def test_carriers_differ_by_what_a_tilt_does_to_the_camera() -> None:
    track = PoseTrack()
    track.add_motion(0.0, motion(HOME))
    track.add_attitude(0.0, angles(0.0, pitch=math.radians(10.0)))
    track.add_gimbal(0.0, gimbal_attitude(quaternion(0.0, -math.pi / 4), YAW_IN_EARTH_FRAME, math.nan))

    def axis(mount: CameraMount) -> np.ndarray:
        return camera_pose(track, mount, 0.0, 0.1)[1][:, 2]

    # Nose up by 10 degrees: what looks down in the body then looks 10 degrees forward, to the north.
    tilt = math.radians(10.0)
    assert axis(CameraMount()) == pytest.approx([0.0, math.sin(tilt), -math.cos(tilt)])
    assert axis(CameraMount(Carrier.LEVEL)) == pytest.approx([0.0, 0.0, -1.0])
    ahead = CameraMount(Carrier.GIMBAL, (0.0, 0.0, 0.0))
    assert axis(ahead) == pytest.approx([0.0, math.sqrt(0.5), -math.sqrt(0.5)])


def test_the_lever_arm_turns_with_the_body() -> None:
    track = PoseTrack()
    track.add_motion(0.0, motion(HOME))
    track.add_attitude(0.0, angles(math.pi / 2))
    mount = CameraMount(lever_arm_frd_m=(0.3, 0.1, 0.2))
    position, _ = camera_pose(track, mount, 0.0, 0.1)
    assert FRAME.to_enu(position) == pytest.approx([0.3, -0.1, -0.2], abs=1e-6)


# --- clocks ----------------------------------------------------------------------------------------------------------


@given(st.integers(0, 2**40), st.integers(-(2**31) + 1, 2**31 - 1))
def test_wrapped_microseconds_are_the_nearest_that_fit(true_us: int, error_us: int) -> None:
    assert unwrap_us(true_us % 2**32, true_us + error_us) == true_us


def test_all_three_forms_of_a_feedback_time_are_the_same_moment() -> None:
    clock = BootClock()
    boot_s, utc_s = 2 * 71.6 * 60 + 12.0, 1_700_000_000.0
    clock.hear_utc(utc_s - 5.0, boot_s - 5.0)
    from_epoch = clock.exposure_time(round(utc_s * 1e6), boot_s + 0.2)
    from_boot = clock.exposure_time(round(boot_s * 1e6) % 2**32, boot_s + 0.2)
    unknown = clock.exposure_time(0, boot_s + 0.2)
    assert from_epoch.boot_s == pytest.approx(boot_s, abs=1e-5)
    assert from_boot.boot_s == pytest.approx(boot_s, abs=1e-5)
    assert unknown.boot_s == boot_s + 0.2
    assert unknown.sigma_s > from_epoch.sigma_s


@given(st.floats(0.0, 1e6), st.integers(0, 9))
def test_a_time_of_day_at_the_moment_of_telemetry_counts_as_since_then(boot_s: float, late_by_ms: int) -> None:
    clock = BootClock()
    clock.hear_utc(1_700_000_000.0, boot_s)
    exposed = clock.exposure_time(1_700_000_000_000_000, boot_s)
    assert exposed.is_since(boot_s + late_by_ms / 1e3)
    assert not exposed.is_since(boot_s + 0.1)


@pytest.mark.parametrize("utc_s", [1_700_000_000.0 + 3600.0, 1_700_000_000.0 - 60.0])
def test_a_time_of_day_that_cannot_be_is_replaced_by_that_of_arrival(utc_s: float) -> None:
    clock = BootClock()
    clock.hear_utc(1_700_000_000.0, 100.0)
    assert clock.exposure_time(round(utc_s * 1e6), 100.5).boot_s == 100.5


def test_a_camera_without_a_clock_tells_no_time_of_day() -> None:
    assert [utc_s_of(time_us) for time_us in (0, 86_400_000_000, 2**64 - 1)] == [None] * 3
    assert utc_s_of(1_700_000_000_500_000) == 1_700_000_000.5


def test_a_time_of_day_without_the_vehicles_own_is_not_believed() -> None:
    clock = BootClock()
    clock.hear_utc(12.0, 11.0)  # no fix yet: SYSTEM_TIME counts from 1970
    assert clock.exposure_time(1_700_000_000_000_000, 100.5).boot_s == 100.5


def test_the_least_delayed_message_gives_the_offset_until_timesync_does() -> None:
    clock = BootClock()
    assert clock.offset_s() is None
    for now_s, delay_s in ((10.0, 0.4), (10.1, 0.02), (10.2, 0.3), (10.3, 0.05)):
        clock.hear_boot(now_s - delay_s + 50.0, now_s)
    assert clock.offset_s() == pytest.approx(49.98)
    assert clock.offset_s(50.0) == 50.0
    assert clock.offset_s(1.7e9) == pytest.approx(49.98)
    clock.hear_boot(1.0, 101.0)
    assert clock.offset_s() == pytest.approx(-100.0)


def test_a_stall_is_a_delay_and_a_lasting_one_another_clock() -> None:
    clock = LeastDelay()
    for now_s in np.arange(0.0, 10.0, 0.1):
        clock.hear(now_s, now_s)
    for now_s in np.arange(10.0, 13.0, 0.1):
        clock.hear(8.0, now_s)
    assert clock.offset_s == pytest.approx(0.0, abs=2e-3)
    for now_s in np.arange(13.0, 20.0, 0.1):
        clock.hear(now_s - 3.0, now_s)
    assert clock.offset_s == pytest.approx(-3.0, abs=2e-3)
    clock.hear(1.0, 20.1)
    clock.hear(1.0, 120.0)
    assert clock.offset_s == pytest.approx(-119.0)


# --- plausibility ----------------------------------------------------------------------------------------------------


def test_absurd_but_finite_poses_are_refused_with_the_reason() -> None:
    track = circling(np.arange(0.0, 5.0, 0.2))
    R = nadir_pose([0, 0, 0]).R_cam2enu
    near = FRAME.to_geodetic((0.0, 15.0, 30.0))
    check_pose(near, R, track, 50.0)
    for far in ((500.0, 0.0, 30.0), (0.0, 10.0, 900.0)):
        with pytest.raises(FrameRefusedError, match=r"m from where the vehicle was.*max_pose_offset_m"):
            check_pose(FRAME.to_geodetic(far), R, track, 50.0)
    with pytest.raises(FrameRefusedError, match="not a rotation"):
        check_pose(near, 2.0 * R, track, 50.0)
    with pytest.raises(FrameRefusedError, match="reflection"):
        check_pose(near, -R, track, 50.0)
    with pytest.raises(FrameRefusedError, match="not on the earth"):
        check_pose(GeodeticPosition(48.3, 14.3, math.inf), R, track, 50.0)
    check_pose(FRAME.to_geodetic((500.0, 0.0, 30.0)), R, PoseTrack(), 50.0)


@pytest.mark.parametrize("q_wxyz", [[3.0, 0.0, 0.0, 0.0], [0.2, 0.1, 0.0, 0.0], [math.nan] * 4])
def test_what_is_no_unit_quaternion_is_no_orientation(q_wxyz: list[float]) -> None:
    with pytest.raises(FrameRefusedError, match="norm"):
        check_quaternion(np.array(q_wxyz))
    check_quaternion(np.array([0.7071, 0.0, 0.0, 0.7071]))
