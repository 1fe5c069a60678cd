"""Rotation matrices from quaternions, angles and rotation vectors.

``R_a2b`` turns vectors given in frame a into frame b. Quaternions are (w, x, y, z), Hamilton's, as in MAVLink.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

_LEVEL_AT_LEAST = 1e-7
"""Cosine of the pitch below which yaw and roll turn about the same axis."""


def R_from_quaternion(q_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix, shape (3, 3), of a quaternion (w, x, y, z); it need not be normalised.

    Raises:
        ValueError: if the quaternion is zero or not finite.
    """
    quaternion = np.asarray(q_wxyz, dtype=np.float64)
    if quaternion.shape != (4,) or not np.all(np.isfinite(quaternion)) or not np.any(quaternion):
        raise ValueError(f"expected a finite non-zero quaternion (w, x, y, z), got {quaternion}")
    # Scaled first: the squares of very small or very large components would be 0 or infinite.
    scaled = quaternion / np.abs(quaternion).max()
    return np.asarray(Rotation.from_quat(scaled, scalar_first=True).as_matrix())


def quaternion_from_R(R: ArrayLike) -> NDArray[np.float64]:
    """Return the quaternion (w, x, y, z) with w >= 0 of a rotation matrix, shape (3, 3)."""
    return np.asarray(Rotation.from_matrix(np.asarray(R)).as_quat(canonical=True, scalar_first=True))


def R_from_yaw_pitch_roll(angles_rad: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return ``R_body2ned``, shape (3, 3), of turns about down, then right, then forward."""
    return np.asarray(Rotation.from_euler("ZYX", angles_rad).as_matrix())


def yaw_pitch_roll_from_R(R_body2ned: ArrayLike) -> tuple[float, float, float]:
    """Return the angles, radians, of which :func:`R_from_yaw_pitch_roll` makes a matrix, shape (3, 3).

    Pitch is within ±π/2. Where it is one of these, as of a camera that looks straight down, roll is 0.
    """
    R = np.asarray(R_body2ned, dtype=np.float64)
    level = float(np.hypot(R[0, 0], R[1, 0]))
    pitch = float(np.arctan2(-R[2, 0], level))
    if level < _LEVEL_AT_LEAST:
        return float(np.arctan2(-R[0, 1], R[1, 1])), pitch, 0.0
    return float(np.arctan2(R[1, 0], R[0, 0])), pitch, float(np.arctan2(R[2, 1], R[2, 2]))


def R_from_rotation_vector(vector_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix, shape (3, 3), of a turn about a vector, shape (3,), by its length in radians."""
    return np.asarray(Rotation.from_rotvec(vector_rad).as_matrix())


def slerp(share: float, start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation at ``share`` (0 to 1) of the shortest path between two, shapes (3, 3)."""
    return np.asarray(Slerp([0.0, 1.0], Rotation.from_matrix(np.stack((start, end))))(share).as_matrix())
