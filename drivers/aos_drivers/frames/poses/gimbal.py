"""Attitudes of gimbals, whose frame MAVLink leaves to flags.

Source: GIMBAL_DEVICE_ATTITUDE_STATUS in https://mavlink.io/en/messages/common.html. Roll and pitch are always about a
levelled frame; only the zero of the yaw differs: north, or the vehicle's heading.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.rotations import R_from_quaternion, R_from_yaw_pitch_roll

YAW_LOCK, YAW_IN_VEHICLE_FRAME, YAW_IN_EARTH_FRAME = 16, 32, 64
"""Bits of GIMBAL_DEVICE_FLAGS."""


@dataclass(frozen=True, slots=True, eq=False)
class GimbalAttitude:
    """Attitude of a gimbal."""

    R_gimbal2level: NDArray[np.float64]
    """Shape (3, 3), forward, right, down, into levelled axes."""
    follows_heading: bool
    """Whether those axes point forward to the vehicle's heading; else to north."""


def gimbal_attitude(q_wxyz: Sequence[float], flags: int, delta_yaw_rad: float) -> GimbalAttitude:
    """Return a gimbal's attitude, relative to north wherever the message allows it.

    Args:
        q_wxyz: as the gimbal reports it.
        flags: as the gimbal reports them; neither of the two frames is the legacy form, where YAW_LOCK decides.
        delta_yaw_rad: the vehicle's heading as the gimbal has it; NaN where it does not tell. Not used in the legacy
            form, which does not define it.

    Raises:
        ValueError: both frames at once, which MAVLink forbids, or no quaternion.
    """
    R = R_from_quaternion(q_wxyz)
    in_vehicle_frame, in_earth_frame = bool(flags & YAW_IN_VEHICLE_FRAME), bool(flags & YAW_IN_EARTH_FRAME)
    if in_vehicle_frame and in_earth_frame:
        raise ValueError("the gimbal gives its yaw in the vehicle's and in the earth's frame at once")
    if in_vehicle_frame and math.isfinite(delta_yaw_rad):
        return GimbalAttitude(R_heading2ned(delta_yaw_rad) @ R, follows_heading=False)
    is_locked = in_earth_frame or (not in_vehicle_frame and bool(flags & YAW_LOCK))
    return GimbalAttitude(R, follows_heading=not is_locked)


def heading_of(R_body2ned: NDArray[np.float64]) -> float:
    """Return the heading in radians, clockwise from north, of a body (forward, right, down)."""
    return math.atan2(R_body2ned[1, 0], R_body2ned[0, 0])


def R_heading2ned(heading_rad: float) -> NDArray[np.float64]:
    """Return the axes of something level, shape (3, 3), that points to a heading."""
    return R_from_yaw_pitch_roll((heading_rad, 0.0, 0.0))
