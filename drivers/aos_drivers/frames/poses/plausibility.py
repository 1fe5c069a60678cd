"""Plausibility checks of reported poses: one wrong frame would spoil the picture of the whole swarm."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.errors import FrameRefusedError
from aos_drivers.frames.poses.track import PoseTrack, position_of
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame

ROTATION_TOLERANCE = 1e-3
"""Tolerance of the elements of R^T R; reported quaternions are of single precision."""
NORM_TOLERANCE = 0.1
"""Largest deviation of a reported quaternion's norm from 1."""


def check_quaternion(q_wxyz: NDArray[np.float64]) -> None:
    """Refuse a quaternion that is not a rotation.

    Raises:
        FrameRefusedError: its norm is not 1.
    """
    norm = float(np.linalg.norm(q_wxyz))
    if not abs(norm - 1.0) <= NORM_TOLERANCE:
        raise FrameRefusedError(f"its orientation is not a rotation: the norm of its quaternion is {norm:.3g}")


def check_pose(
    position: GeodeticPosition, R_cam2enu: NDArray[np.float64], track: PoseTrack, max_offset_m: float
) -> None:
    """Refuse a pose that cannot be that of a camera on the vehicle.

    Args:
        position: position of the camera.
        R_cam2enu: its orientation, shape (3, 3).
        track: motion that the vehicle itself reports; without any position, only the orientation is checked.
        max_offset_m: largest distance between the camera and the vehicle's recent positions; links and clocks of a
            swarm are too uncertain for less than some metres.

    Raises:
        FrameRefusedError: with the reason.
    """
    is_finite = R_cam2enu.shape == (3, 3) and bool(np.isfinite(R_cam2enu).all())
    if not is_finite or np.abs(R_cam2enu.T @ R_cam2enu - np.eye(3)).max() > ROTATION_TOLERANCE:
        raise FrameRefusedError("its orientation is not a rotation")
    if np.linalg.det(R_cam2enu) < 0.0:
        raise FrameRefusedError("its orientation is a reflection, not a rotation")
    values = (position.latitude_deg, position.longitude_deg, position.altitude_amsl_m)
    if not all(map(math.isfinite, values)) or abs(position.latitude_deg) > 90.0:
        raise FrameRefusedError(f"its position {values} is not on the earth")
    offset_m = _offset_m(position, track, max_offset_m)
    if offset_m > max_offset_m:
        raise FrameRefusedError(
            f"its position is {offset_m:.0f} m from where the vehicle was; the limit is {max_offset_m:g} m "
            "(max_pose_offset_m)"
        )


def _offset_m(position: GeodeticPosition, track: PoseTrack, enough_m: float) -> float:
    """Return the distance from the nearest of the vehicle's latest positions, or from the first within ``enough_m``."""
    frame, nearest_m = LocalFrame(position), math.inf
    for motion in reversed(track.motions.values):
        nearest_m = min(nearest_m, float(np.linalg.norm(frame.to_enu(position_of(motion)))))
        if nearest_m <= enough_m:
            break
    return nearest_m if len(track.motions) else 0.0
