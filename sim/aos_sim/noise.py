"""Errors of real vehicles and cameras: what they report differs from where they are and what there is to see.

The defaults are the error budget of a small multirotor in the field: positions by satellite to 0.5 m (by RTK to
0.02 m), attitude to 1 degree, heading to 3 degrees, exposure times to 30 ms. All are standard deviations; those of
positions and of roll and pitch are per axis. An error has a part that stays with the vehicle for minutes (atmosphere
and multipath, mounting, compass, latency) and a part that differs from one exposure to the next: only the second
averages out over the steps of a hovering vehicle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.poses import Pose

FloatArray = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PoseErrors:
    """Errors of a vehicle's reported pose."""

    position_m: float = 0.5
    """Horizontal, east and north each."""
    vertical_ratio: float = 1.5
    """Ratio of the vertical to the horizontal position error; satellites are above the vehicle, none below it."""
    position_lasting_share: float = 0.9
    """Part of the position's variance that stays."""
    tilt_rad: float = math.radians(1.0)
    """Roll and pitch each."""
    tilt_lasting_share: float = 0.5
    yaw_rad: float = math.radians(3.0)
    yaw_lasting_share: float = 0.95
    clock_s: float = 0.03
    """Constant error between an exposure and the time that its pose is reported for."""


GNSS = PoseErrors()
RTK = PoseErrors(position_m=0.02)


@dataclass(frozen=True, slots=True, eq=False)
class LastingErrors:
    """The parts that stay with each vehicle; one row per vehicle."""

    position_enu_m: NDArray[np.float64]
    """Shape (n, 3)."""
    rotation_enu_rad: NDArray[np.float64]
    """Rotation vector, shape (n, 3): about east and north by the tilt, about up by minus the heading's error."""
    clock_s: NDArray[np.float64]
    """Shape (n,)."""


def draw_lasting_errors(rng: np.random.Generator, errors: PoseErrors, vehicles: int) -> LastingErrors:
    """Draw what stays with each vehicle; equal generators give equal draws up to the scale of the errors."""
    position, rotation = _deviations(errors)
    shares = _lasting_shares(errors)
    return LastingErrors(
        position_enu_m=rng.standard_normal((vehicles, 3)) * position * math.sqrt(errors.position_lasting_share),
        rotation_enu_rad=rng.standard_normal((vehicles, 3)) * rotation * np.sqrt(shares),
        clock_s=rng.standard_normal(vehicles) * errors.clock_s,
    )


def reported_pose(
    rng: np.random.Generator,
    pose: Pose,
    errors: PoseErrors,
    lasting: LastingErrors,
    *,
    vehicle: int,
    velocity_enu_mps: NDArray[np.float64],
) -> Pose:
    """Return what a vehicle reports of its camera's true pose at one exposure.

    Args:
        rng: draws what differs from one exposure to the next.
        pose: the true one.
        errors: their sizes.
        lasting: the lasting part.
        vehicle: row of ``lasting``.
        velocity_enu_mps: velocity of the vehicle at exposure, shape (3,); turns the clock's error into one of position.
    """
    position, rotation = _deviations(errors)
    passing_m = rng.standard_normal(3) * position * math.sqrt(1.0 - errors.position_lasting_share)
    passing_rad = rng.standard_normal(3) * rotation * np.sqrt(1.0 - _lasting_shares(errors))
    shift_m = lasting.position_enu_m[vehicle] + passing_m + lasting.clock_s[vehicle] * velocity_enu_mps
    turn = Rotation.from_rotvec(lasting.rotation_enu_rad[vehicle] + passing_rad).as_matrix()
    return Pose(pose.position_enu_m + shift_m, turn @ pose.R_cam2enu)


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Errors that an uncooled thermal camera adds to the temperatures of a scene."""

    netd_k: float = 0.05
    """Noise of a pixel from frame to frame."""
    offset_k: float = 1.0
    """Offset of the whole image, per camera: the calibration drifts with the housing."""
    shading_k: float = 0.3
    """Smooth over the image, per camera: the lens and the housing glow."""
    column_k: float = 0.05
    """Fixed pattern of the read-out, one value per column and camera."""


def draw_thermal_pattern(rng: np.random.Generator, errors: SensorErrors, shape: tuple[int, int]) -> FloatArray:
    """Draw one camera's nonuniformity in kelvin, shape (H, W): what stays between two shutter calibrations."""
    height, width = shape
    # A coarse grid of random values, interpolated: smooth over a quarter of the image.
    knots = rng.standard_normal((5, 5)).astype(np.float32) * np.float32(errors.shading_k)
    shading = cv2.resize(knots, (width, height), interpolation=cv2.INTER_CUBIC)
    columns = rng.standard_normal(width, dtype=np.float32) * np.float32(errors.column_k)
    return np.asarray(shading + columns + np.float32(rng.standard_normal() * errors.offset_k), dtype=np.float32)


def _deviations(errors: PoseErrors) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Standard deviations of position (east, north, up) and rotation vector, each of shape (3,)."""
    position = errors.position_m * np.array([1.0, 1.0, errors.vertical_ratio])
    return position, np.array([errors.tilt_rad, errors.tilt_rad, errors.yaw_rad])


def _lasting_shares(errors: PoseErrors) -> NDArray[np.float64]:
    """Parts of the rotation vector's variance that stay, shape (3,)."""
    return np.array([errors.tilt_lasting_share, errors.tilt_lasting_share, errors.yaw_lasting_share])
