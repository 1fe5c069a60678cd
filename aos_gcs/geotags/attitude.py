"""The attitude of the camera that took a photograph, in the tags of its manufacturer.

| tags | written by | attitude |
|---|---|---|
| ``GimbalYawDegree``, ``GimbalPitchDegree``, ``GimbalRollDegree`` | DJI, Autel | of the optical axis, -90 is down |
| ``CameraYawDegree``, ``CameraPitchDegree``, ``CameraRollDegree`` | Parrot | of the optical axis |
| ``CameraOrientationNED`` with ``Yaw``, ``Pitch``, ``Roll`` | Skydio | of the optical axis |
| ``CameraYaw``, ``CameraPitch``, ``CameraRoll`` | Teal | of the optical axis, on ``PlatformYaw`` … |
| ``Camera:Yaw``, ``Camera:Pitch``, ``Camera:Roll`` | Pix4D's scheme: senseFly, early Autel | pitch 0 is down |

Angles are degrees about north, east and down, turned in the order yaw, pitch, roll.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, R_NED2ENU
from aos_gcs.geometry.rotations import R_from_yaw_pitch_roll
from aos_gcs.geotags.xmp import first_number

R_CAM2NADIR_FRD: NDArray[np.float64] = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""OpenCV camera axes to those of a body that carries a camera looking down, its upper edge forward."""

_OF_THE_AXIS = (
    ("GimbalYawDegree", "GimbalPitchDegree", "GimbalRollDegree"),
    ("FlightYawDegree", "GimbalPitchDegree", "GimbalRollDegree"),
    ("CameraYawDegree", "CameraPitchDegree", "CameraRollDegree"),
    ("CameraOrientationNED/Yaw", "CameraOrientationNED/Pitch", "CameraOrientationNED/Roll"),
)
"""Names of yaw, pitch and roll of the optical axis, in the order in which they are looked for."""
_PLATFORM = ("PlatformYaw", "PlatformPitch", "PlatformRoll")
_ON_PLATFORM = ("CameraYaw", "CameraPitch", "CameraRoll")
_PIX4D = ("Yaw", "Pitch", "Roll")

_MIN_PIX4D_PITCH_DEG = -45.0
"""Pitch of Pix4D's scheme below which a camera would look back: Autel's EVO Lite Enterprise 640T counts from the
horizon."""


def R_cam2enu_of_tags(xmp: Mapping[str, str]) -> NDArray[np.float64]:
    """Return the orientation of the picture as it is to be shown, shape (3, 3).

    Raises:
        InputDataError: if the tags do not tell it, or the gimbal has not reported.
    """
    for names in _OF_THE_AXIS:
        angles_deg = _angles_deg(xmp, names)
        if angles_deg is not None:
            if angles_deg == (0.0, 0.0, 0.0) and first_number(xmp, "FlightYawDegree"):
                # DJI's Mini 2 writes this of a camera that looks down.
                raise InputDataError(f"its {', '.join(names)} are all 0: the gimbal has not reported its angles")
            return R_cam2enu_of_gimbal(*angles_deg)
    platform_deg, on_platform_deg = _angles_deg(xmp, _PLATFORM), _angles_deg(xmp, _ON_PLATFORM)
    if platform_deg is not None and on_platform_deg is not None:
        return R_cam2enu_of_gimbal(*platform_deg, _R_turned(*on_platform_deg) @ R_CAM2SENSOR_FRD)
    pix4d_deg = _angles_deg(xmp, _PIX4D)
    if pix4d_deg is not None:
        is_from_horizon = pix4d_deg[1] < _MIN_PIX4D_PITCH_DEG
        return R_cam2enu_of_gimbal(*pix4d_deg, R_CAM2SENSOR_FRD if is_from_horizon else R_CAM2NADIR_FRD)
    raise InputDataError("it has no GimbalYawDegree and GimbalPitchDegree, nor another known attitude of the camera")


def R_cam2enu_of_gimbal(
    yaw_deg: float, pitch_deg: float, roll_deg: float = 0.0, R_cam2body: NDArray[np.float64] = R_CAM2SENSOR_FRD
) -> NDArray[np.float64]:
    """Return the orientation of a camera, shape (3, 3), from angles about north, east and down.

    Args:
        yaw_deg: clockwise from north.
        pitch_deg: upwards.
        roll_deg: clockwise as seen by the camera.
        R_cam2body: OpenCV camera axes to the axes that the angles turn; by default those of the optical axis.
    """
    return np.asarray(R_NED2ENU @ _R_turned(yaw_deg, pitch_deg, roll_deg) @ R_cam2body)


def _R_turned(yaw_deg: float, pitch_deg: float, roll_deg: float) -> NDArray[np.float64]:
    return R_from_yaw_pitch_roll((math.radians(yaw_deg), math.radians(pitch_deg), math.radians(roll_deg)))


def _angles_deg(xmp: Mapping[str, str], names: tuple[str, str, str]) -> tuple[float, float, float] | None:
    """Return yaw, pitch and roll, which is 0 where it is not told; None without one of the others."""
    yaw_deg, pitch_deg, roll_deg = (first_number(xmp, name) for name in names)
    return None if yaw_deg is None or pitch_deg is None else (yaw_deg, pitch_deg, roll_deg or 0.0)
