"""Which frames can be used: one that cannot must not cost the step."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from aos_gcs.errors import ImagingError, UnusableFramesError
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.integral import check_frame
from aos_gcs.imaging.model import Frame, Pixels

ROTATION_TOLERANCE = 1e-3
"""Of the elements of R^T R; reported quaternions are of single precision, normalised."""

_STRIDE = 16
"""Of the pixels that are looked at first: an image that varies among them is not constant."""


def usable_frames(frames: Sequence[Frame], plane_height_m: float) -> tuple[list[Frame], dict[int, str]]:
    """Return the frames that can be integrated, and why the others cannot, by vehicle.

    Args:
        frames: of one step.
        plane_height_m: ENU height of the focal plane.

    Raises:
        ImagingError: if there is no frame.
        UnusableFramesError: if none can be used; it gives the reasons.
    """
    if not frames:
        raise ImagingError("There is no frame to analyse: give at least one.")
    bands = Counter(frame.bands for frame in frames).most_common(1)[0][0]
    reasons = [_why_unusable(frame, bands, plane_height_m) for frame in frames]
    usable = [frame for frame, reason in zip(frames, reasons, strict=True) if reason is None]
    skipped = {frame.vehicle_id: reason for frame, reason in zip(frames, reasons, strict=True) if reason is not None}
    if not usable:
        told = "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in skipped.items())
        raise UnusableFramesError(f"No frame can be used ({told}).", skipped)
    return usable, skipped


def _why_unusable(frame: Frame, bands: tuple[str, ...], plane_height_m: float) -> str | None:
    try:
        check_frame(frame, bands)
    except ImagingError as error:
        return str(error)
    camera = frame.camera
    if not all(math.isfinite(value) for value in (camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px)):
        return "its camera's intrinsics are not known"
    if camera.fx_px <= 0.0 or camera.fy_px <= 0.0:
        return f"its camera's focal lengths are not positive ({camera.fx_px:g}, {camera.fy_px:g})"
    return _why_misplaced(frame.pose) or _why_blind(frame, plane_height_m) or _why_empty(frame.image)


def _why_misplaced(pose: Pose) -> str | None:
    position_enu_m, R = pose.position_enu_m, pose.R_cam2enu
    if position_enu_m.shape != (3,) or not np.isfinite(position_enu_m).all():
        return f"its position is not known ({position_enu_m})"
    if R.shape != (3, 3) or not np.isfinite(R).all():
        return "its orientation is not known"
    if np.abs(R.T @ R - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        return "its orientation is not a rotation"
    return None


def _why_blind(frame: Frame, plane_height_m: float) -> str | None:
    if len(footprint(frame.camera, frame.pose, plane_height_m)):
        return None
    return (
        f"it does not see the focal plane at a height of {plane_height_m:g} m (its camera is at "
        f"{frame.pose.position_enu_m[2]:.1f} m): choose a plane below the cameras and point them towards the ground"
    )


def _why_empty(image: Pixels) -> str | None:
    """Tell what is wrong with an image that shows nothing: it would only take contrast from the integral."""
    reason = _why_constant(image[::_STRIDE, ::_STRIDE])
    return None if reason is None else _why_constant(image)


def _why_constant(image: Pixels) -> str | None:
    finite = image[np.isfinite(image).all(axis=2)]
    if not finite.size:
        return "its image has no finite pixel"
    if (finite == finite[0]).all():
        return f"its image is the same everywhere ({', '.join(f'{value:g}' for value in finite[0])})"
    return None
