"""The true pose of a camera at an exposure, which differs from what its vehicle reports."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.rotations import R_from_rotation_vector
from aos_sim.errors.gimbal import GimbalErrors
from aos_sim.errors.sizes import FloatArray
from aos_sim.errors.timing import TimingErrors

_LEAST_HEIGHT_M = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """True motion of a vehicle at the moment that its pose is reported for."""

    position_enu_m: FloatArray
    """Shape (3,)."""
    heading_rad: float
    """Clockwise from north."""
    velocity_enu_mps: FloatArray
    """Shape (3,)."""
    rates_radps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Rates of roll, pitch and heading."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueExposure:
    """What a camera does when an image is taken."""

    pose: Pose
    speed_pxps: tuple[float, float]
    """Velocity of the ground in the middle of the image, right and down."""


class CameraErrors:
    """Gimbals and shutters of all cameras: equal arguments give equal exposures, in whatever order.

    Args:
        gimbal: errors of the gimbals.
        timing: errors of the exposure times.
        seed: of the draws.
    """

    def __init__(self, gimbal: GimbalErrors, timing: TimingErrors, seed: int) -> None:
        self._gimbal, self._timing, self._seed = gimbal, timing, seed
        self._constant = lru_cache(maxsize=256)(self._draw_constant)

    def expose(self, camera_id: int, index: int, motion: Motion, camera: CameraModel) -> TrueExposure:
        """Return where a camera is, and looks to, when it takes its image number ``index``."""
        late_s, turn_rad = self._constant(camera_id)
        rng = np.random.default_rng([self._seed, 0xC1, camera_id, index])
        late_s = late_s + float(rng.standard_normal()) * self._timing.jitter_s
        jitter_rad = rng.standard_normal(3) * self._gimbal.jitter_rad
        roll_rate, pitch_rate, yaw_rate = motion.rates_radps
        # Camera axes: right, backwards, down. What the body turns by reaches the camera with the gimbal's lag.
        lag_rad = self._gimbal.lag_s * np.array([pitch_rate, -roll_rate, -yaw_rate])
        position_enu_m = motion.position_enu_m + late_s * motion.velocity_enu_mps
        level = nadir_pose(position_enu_m, motion.heading_rad + late_s * yaw_rate)
        turn = R_from_rotation_vector(turn_rad + jitter_rad + lag_rad)
        pose = Pose(level.position_enu_m, level.R_cam2enu @ turn)
        height_m = max(_LEAST_HEIGHT_M, float(position_enu_m[2]))
        right_mps, down_mps, _ = -motion.velocity_enu_mps @ pose.R_cam2enu
        return TrueExposure(pose, (camera.fx_px * right_mps / height_m, camera.fy_px * down_mps / height_m))

    def _draw_constant(self, camera_id: int) -> tuple[float, FloatArray]:
        """Draw a camera's mean delay and its constant turn about its axes, shape (3,)."""
        rng = np.random.default_rng([self._seed, 0xC0, camera_id])
        late_s = self._timing.delay_s + float(rng.standard_normal()) * self._timing.clock_s
        sizes_rad = np.array([self._gimbal.tilt_rad, self._gimbal.tilt_rad, self._gimbal.pan_rad])
        return late_s, rng.standard_normal(3) * sizes_rad
