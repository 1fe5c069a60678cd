"""Checks of frames: one that cannot be used must not cost the step."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.errors import ImagingError, UnusableFramesError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.integral import check_shape
from aos_gcs.imaging.step.examination import ExaminedFrame

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of an element of R^T R from the identity; reported quaternions have single precision."""


@dataclass(frozen=True, slots=True, eq=False)
class UsableFrames:
    """The frames of a step that can be integrated."""

    frames: tuple[ExaminedFrame, ...]
    """One frame or more; all have the same bands, and temperatures or grey levels in ``thermal``."""
    skipped: Mapping[int, str]
    """Reason why a frame cannot be used, by vehicle."""


def usable_frames(frames: Sequence[ExaminedFrame], plane_height_m: float) -> UsableFrames:
    """Return the frames that can be integrated, and why the others cannot.

    Args:
        frames: frames of one step.
        plane_height_m: ENU height of the focal plane.

    Raises:
        ImagingError: if there is no frame.
        UnusableFramesError: if none can be used; it gives the reasons.
    """
    if not frames:
        raise ImagingError("There is no frame to analyse: give at least one.")
    bands, tell_temperatures = Counter((frame.bands, frame.tells_temperatures) for frame in frames).most_common(1)[0][0]
    usable, skipped = [], {}
    for frame in frames:
        try:
            _check_usable(frame, bands, plane_height_m, tell_temperatures=tell_temperatures)
        except ImagingError as error:
            skipped[frame.vehicle_id] = str(error)
        else:
            usable.append(frame)
    if not usable:
        reasons = "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in skipped.items())
        raise UnusableFramesError(f"No frame can be used ({reasons}).", skipped)
    return UsableFrames(tuple(usable), skipped)


def _check_usable(
    frame: ExaminedFrame, bands: tuple[str, ...], plane_height_m: float, *, tell_temperatures: bool
) -> None:
    """Refuse a frame that cannot be integrated.

    Raises:
        ImagingError: giving the reason.
    """
    check_shape(frame, frame.shape, bands)
    _check_camera(frame.camera)
    _check_pose(frame.pose)
    if not len(footprint(frame.camera, frame.pose, plane_height_m)):
        raise ImagingError(
            f"it does not see the focal plane at a height of {plane_height_m:g} m (its camera is at "
            f"{frame.pose.position_enu_m[2]:.1f} m): choose a plane below the cameras and point them towards the ground"
        )
    if frame.fault:
        raise ImagingError(frame.fault)
    if frame.tells_temperatures and not tell_temperatures:
        raise ImagingError("its band thermal holds temperatures, others have grey levels: have all cameras deliver one")
    if tell_temperatures and not frame.tells_temperatures:
        raise ImagingError("its band thermal holds grey levels, others have temperatures: have all cameras deliver one")


def _check_camera(camera: CameraModel) -> None:
    if not all(math.isfinite(value) for value in (camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px)):
        raise ImagingError("its camera's intrinsics are not known")
    if camera.fx_px <= 0.0 or camera.fy_px <= 0.0:
        raise ImagingError(f"its camera's focal lengths are not positive ({camera.fx_px:g}, {camera.fy_px:g})")


def _check_pose(pose: Pose) -> None:
    position_enu_m, R = pose.position_enu_m, pose.R_cam2enu
    if position_enu_m.shape != (3,) or not np.isfinite(position_enu_m).all():
        raise ImagingError(f"its position is not known ({position_enu_m})")
    if R.shape != (3, 3) or not np.isfinite(R).all():
        raise ImagingError("its orientation is not known")
    if np.abs(R.T @ R - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise ImagingError("its orientation is not a rotation")
