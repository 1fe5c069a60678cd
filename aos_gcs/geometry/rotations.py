"""Rotation matrices from quaternions, angles and rotation vectors.

``R_a2b`` turns vectors given in frame a into frame b. Quaternions are (w, x, y, z), Hamilton's, as in MAVLink.

Every process of the program imports this module, and SciPy's rotations would take it half a second more to start. The
steps are SciPy's, so the results are, too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

_LEVEL_AT_LEAST = 1e-7
"""Cosine of the pitch below which yaw and roll turn about the same axis."""
_ORTHOGONAL_WITHIN = 1e-12
"""Difference of products of rows from those of a rotation above which the nearest rotation is taken."""
_SMALL_RAD = 1e-3
"""Angle below which quotients of sines are series."""


class _Quaternion(NamedTuple):
    x: float
    y: float
    z: float
    w: float

    def normalised(self) -> _Quaternion:
        x, y, z, w = self
        norm = math.sqrt(x * x + y * y + z * z + w * w)
        return _Quaternion(x / norm, y / norm, z / norm, w / norm)

    def inverse(self) -> _Quaternion:
        """Return the opposite turn of a quaternion of norm 1."""
        return _Quaternion(-self.x, -self.y, -self.z, self.w)

    def after(self, first: _Quaternion) -> _Quaternion:
        """Return the turn by ``first`` and then by this one."""
        x, y, z, w = self
        return _Quaternion(
            w * first.x + first.w * x + (y * first.z - z * first.y),
            w * first.y + first.w * y + (z * first.x - x * first.z),
            w * first.z + first.w * z + (x * first.y - y * first.x),
            w * first.w - x * first.x - y * first.y - z * first.z,
        )

    def matrix(self) -> NDArray[np.float64]:
        """Return the rotation matrix, shape (3, 3), of a quaternion of norm 1."""
        x, y, z, w = self
        x2, y2, z2, w2 = x * x, y * y, z * z, w * w
        xy, zw, xz, yw, yz, xw = x * y, z * w, x * z, y * w, y * z, x * w
        return np.array(
            (
                (x2 - y2 - z2 + w2, 2.0 * (xy - zw), 2.0 * (xz + yw)),
                (2.0 * (xy + zw), -x2 + y2 - z2 + w2, 2.0 * (yz - xw)),
                (2.0 * (xz - yw), 2.0 * (yz + xw), -x2 - y2 + z2 + w2),
            )
        )

    def rotation_vector(self) -> tuple[float, float, float]:
        """Return the turn about a vector by its length, at most pi, of a quaternion of norm 1."""
        x, y, z, w = self if self.w >= 0.0 else _Quaternion(-self.x, -self.y, -self.z, -self.w)
        angle = 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), w)
        angle2 = angle * angle
        scale = 2.0 + angle2 / 12.0 + 7.0 * angle2 * angle2 / 2880.0
        if angle > _SMALL_RAD:
            scale = angle / math.sin(angle / 2.0)
        return x * scale, y * scale, z * scale


def R_from_quaternion(q_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix, shape (3, 3), of a quaternion (w, x, y, z); it need not be normalised.

    Raises:
        ValueError: if the quaternion is zero or not finite.
    """
    quaternion = np.asarray(q_wxyz, dtype=np.float64)
    if quaternion.shape != (4,) or not np.all(np.isfinite(quaternion)) or not np.any(quaternion):
        raise ValueError(f"expected a finite non-zero quaternion (w, x, y, z), got {quaternion}")
    # Scaled first: the squares of very small or very large components would be 0 or infinite.
    w, x, y, z = (quaternion / np.abs(quaternion).max()).tolist()
    return _Quaternion(x, y, z, w).normalised().matrix()


def quaternion_from_R(R: ArrayLike) -> NDArray[np.float64]:
    """Return the quaternion (w, x, y, z) with w >= 0 of a rotation matrix, shape (3, 3), or of the nearest one.

    Raises:
        ValueError: if the matrix is a reflection, or singular.
    """
    x, y, z, w = _quaternion_of(np.asarray(R, dtype=np.float64))
    return np.array((-w, -x, -y, -z) if _is_other_half(x, y, z, w) else (w, x, y, z))


def R_from_yaw_pitch_roll(angles_rad: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return ``R_body2ned``, shape (3, 3), of turns about down, then right, then forward."""
    (yaw_sin, yaw_cos), (pitch_sin, pitch_cos), (roll_sin, roll_cos) = (
        (math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in map(float, angles_rad)
    )
    yaw, pitch = _Quaternion(0.0, 0.0, yaw_sin, yaw_cos), _Quaternion(0.0, pitch_sin, 0.0, pitch_cos)
    return yaw.after(pitch).after(_Quaternion(roll_sin, 0.0, 0.0, roll_cos)).matrix()


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
    x, y, z = np.asarray(vector_rad, dtype=np.float64).tolist()
    return _from_rotation_vector(x, y, z).matrix()


def slerp(share: float, start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation at ``share`` (0 to 1) of the shortest path between two, shapes (3, 3)."""
    first = _quaternion_of(start)
    x, y, z = first.inverse().after(_quaternion_of(end)).normalised().rotation_vector()
    return first.after(_from_rotation_vector(x * share, y * share, z * share)).normalised().matrix()


def _quaternion_of(R: NDArray[np.float64]) -> _Quaternion:
    """Return one of the two quaternions of a rotation matrix, shape (3, 3), or of the nearest one."""
    if R.shape != (3, 3) or not np.linalg.det(R) > 0.0:
        raise ValueError(f"expected a rotation matrix, shape (3, 3), got {R}")
    if np.abs(R @ R.T - np.eye(3)).max() > _ORTHOGONAL_WITHIN:
        left, _, right = np.linalg.svd(R)
        R = left @ right
    (m00, m01, m02), (m10, m11, m12), (m20, m21, m22) = R.tolist()
    trace = m00 + m11 + m22
    # From the largest component: the others are quotients by it.
    largest = max(m00, m11, m22, trace)
    if m00 == largest:
        found = _Quaternion(1.0 - trace + 2.0 * m00, m10 + m01, m20 + m02, m21 - m12)
    elif m11 == largest:
        found = _Quaternion(m10 + m01, 1.0 - trace + 2.0 * m11, m21 + m12, m02 - m20)
    elif m22 == largest:
        found = _Quaternion(m20 + m02, m21 + m12, 1.0 - trace + 2.0 * m22, m10 - m01)
    else:
        found = _Quaternion(m21 - m12, m02 - m20, m10 - m01, 1.0 + trace)
    return found.normalised()


def _is_other_half(x: float, y: float, z: float, w: float) -> bool:
    """Return whether a quaternion is the one of the two of its rotation whose first part that is not 0 is negative."""
    return next((part < 0.0 for part in (w, x, y, z) if part != 0.0), False)


def _from_rotation_vector(x: float, y: float, z: float) -> _Quaternion:
    angle = math.sqrt(x * x + y * y + z * z)
    angle2 = angle * angle
    scale = 0.5 - angle2 / 48.0 + angle2 * angle2 / 3840.0
    if angle > _SMALL_RAD:
        scale = math.sin(angle / 2.0) / angle
    return _Quaternion(scale * x, scale * y, scale * z, math.cos(angle / 2.0))
