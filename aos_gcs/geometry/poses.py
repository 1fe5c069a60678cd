"""Orientations and camera poses.

Cameras follow OpenCV: x right, y down, z forward (along the optical axis). ``R_a2b`` turns vectors given in frame a
into frame b. Quaternions are (w, x, y, z), as in MAVLink.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.rotations import R_from_quaternion, quaternion_from_R

R_NED2ENU: NDArray[np.float64] = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""North-east-down to east-north-up (its own inverse)."""

R_CAM2SENSOR_FRD: NDArray[np.float64] = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""OpenCV camera axes to MAVLink's camera axes, whose x (forward) is the optical axis, y right and z down."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Position and orientation of a camera."""

    position_enu_m: NDArray[np.float64]
    """Projection centre, shape (3,), metres in the mission's ENU frame."""

    R_cam2enu: NDArray[np.float64]
    """Rotation matrix, shape (3, 3)."""


def R_cam2enu_from_mavlink(q_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Return ``R_cam2enu`` from MAVLink's camera quaternion (camera forward-right-down to NED).

    Raises:
        ValueError: if the quaternion is zero or not finite.
    """
    return R_NED2ENU @ R_from_quaternion(q_wxyz) @ R_CAM2SENSOR_FRD


def mavlink_quaternion_from_R_cam2enu(R_cam2enu: ArrayLike) -> NDArray[np.float64]:
    """Inverse of :func:`R_cam2enu_from_mavlink`."""
    return quaternion_from_R(R_NED2ENU @ np.asarray(R_cam2enu) @ R_CAM2SENSOR_FRD.T)


def nadir_pose(position_enu_m: ArrayLike, heading_rad: float = 0.0) -> Pose:
    """Pose of a camera that looks straight down.

    The upper image edge points to ``heading_rad``, clockwise from north.
    """
    sin, cos = math.sin(heading_rad), math.cos(heading_rad)
    R_cam2enu = np.array([[cos, -sin, 0.0], [-sin, -cos, 0.0], [0.0, 0.0, -1.0]])
    return Pose(np.asarray(position_enu_m, dtype=np.float64), R_cam2enu)
