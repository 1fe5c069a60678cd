"""Rotation matrices, made of quaternions, angles and vectors.

``R_a2b`` turns vectors given in frame a into frame b. Quaternions are (w, x, y, z), Hamilton's, as in MAVLink. Written
out, because SciPy's module for rotations takes half a second to import, in every process that knows a pose.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def R_from_quaternion(q_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix, shape (3, 3), of a quaternion (w, x, y, z); it need not be normalised.

    Raises:
        ValueError: if the quaternion is zero or not finite.
    """
    quaternion = np.asarray(q_wxyz, dtype=np.float64)
    if quaternion.shape != (4,) or not np.all(np.isfinite(quaternion)) or not np.any(quaternion):
        raise ValueError(f"expected a finite non-zero quaternion (w, x, y, z), got {quaternion}")
    # Scaled first: the squares of very small or very large components would be 0 or infinite.
    quaternion = quaternion / np.abs(quaternion).max()
    w, x, y, z = (quaternion / np.linalg.norm(quaternion)).tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def quaternion_from_R(R: ArrayLike) -> NDArray[np.float64]:
    """Return the quaternion (w, x, y, z) with w >= 0 of a rotation matrix, shape (3, 3).

    Source: Shepperd, *Quaternion from rotation matrix*, Journal of Guidance and Control 1(3), 1978.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(R, dtype=np.float64).tolist()
    # Each row is the quaternion times four times one of its components; the largest of them has the most digits.
    rows = np.array(
        [
            [1.0 + a + e + i, h - f, c - g, d - b],
            [h - f, 1.0 + a - e - i, b + d, c + g],
            [c - g, b + d, 1.0 - a + e - i, f + h],
            [d - b, c + g, f + h, 1.0 - a - e + i],
        ]
    )
    row = rows[int(np.argmax(np.diagonal(rows)))]
    return np.asarray(row / math.copysign(float(np.linalg.norm(row)), row[0]))


def R_from_yaw_pitch_roll(angles_rad: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return ``R_body2ned``, shape (3, 3), of turns about down, then right, then forward."""
    yaw_rad, pitch_rad, roll_rad = angles_rad
    sin_y, cos_y = math.sin(yaw_rad), math.cos(yaw_rad)
    sin_p, cos_p = math.sin(pitch_rad), math.cos(pitch_rad)
    sin_r, cos_r = math.sin(roll_rad), math.cos(roll_rad)
    return np.array(
        [
            [cos_y * cos_p, cos_y * sin_p * sin_r - sin_y * cos_r, cos_y * sin_p * cos_r + sin_y * sin_r],
            [sin_y * cos_p, sin_y * sin_p * sin_r + cos_y * cos_r, sin_y * sin_p * cos_r - cos_y * sin_r],
            [-sin_p, cos_p * sin_r, cos_p * cos_r],
        ]
    )


def R_from_rotation_vector(vector_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix, shape (3, 3), of a turn about a vector, shape (3,), by its length in radians."""
    vector = np.asarray(vector_rad, dtype=np.float64)
    half_rad = 0.5 * float(np.linalg.norm(vector))
    # sinc keeps turns by nothing from dividing by zero: sin(x) / (2 x) for half the angle x.
    return R_from_quaternion((math.cos(half_rad), *(0.5 * np.sinc(half_rad / math.pi) * vector)))


def slerp(share: float, start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation at ``share`` (0 to 1) of the shortest path between two, shapes (3, 3).

    Source: Shoemake, *Animating rotation with quaternion curves*, SIGGRAPH 1985.
    """
    w, *xyz = quaternion_from_R(start.T @ end)
    sin_half = float(np.linalg.norm(xyz))
    if sin_half == 0.0:
        return start
    turn_rad = share * 2.0 * math.atan2(sin_half, w)
    return start @ R_from_rotation_vector(turn_rad / sin_half * np.array(xyz))
