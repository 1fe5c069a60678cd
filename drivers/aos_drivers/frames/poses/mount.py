"""Pose of a vehicle's camera, computed from the vehicle's motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.poses.gimbal import R_heading2ned, heading_of
from aos_drivers.frames.poses.track import PoseTrack
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, R_NED2ENU
from aos_gcs.geometry.rotations import R_from_yaw_pitch_roll


class Carrier(StrEnum):
    """Part of the vehicle that the camera is fixed to."""

    BODY = "body"
    """The airframe."""
    LEVEL = "level"
    """A gimbal that keeps the horizon and follows the heading, and reports nothing."""
    GIMBAL = "gimbal"
    """A gimbal that reports its attitude."""


@dataclass(frozen=True, slots=True)
class CameraMount:
    """Mounting of a camera.

    Yaw, pitch and roll of the optical axis about down, right and forward of its carrier, turned in this order, as in
    the tags of photographs: pitch -90 degrees looks down, with the upper edge of the image forward.
    """

    carrier: Carrier = Carrier.BODY
    yaw_pitch_roll_rad: tuple[float, float, float] = (0.0, -math.pi / 2, 0.0)
    lever_arm_frd_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Projection centre relative to the point whose position the vehicle reports: forward, right, down in the body."""

    @property
    def R_cam2carrier(self) -> NDArray[np.float64]:
        """Shape (3, 3); the carrier's axes are forward, right, down."""
        return np.asarray(R_from_yaw_pitch_roll(self.yaw_pitch_roll_rad) @ R_CAM2SENSOR_FRD)

    def camera_position(self, vehicle: GeodeticPosition, R_body2ned: NDArray[np.float64]) -> GeodeticPosition:
        """Return the projection centre for a position and an attitude of the vehicle."""
        if not any(self.lever_arm_frd_m):
            return vehicle
        return LocalFrame(vehicle).to_geodetic(R_NED2ENU @ R_body2ned @ np.array(self.lever_arm_frd_m))

    def R_cam2enu(self, R_carrier2ned: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the camera's orientation, shape (3, 3), for an orientation of its carrier."""
        return np.asarray(R_NED2ENU @ R_carrier2ned @ self.R_cam2carrier)


def camera_pose(
    track: PoseTrack,
    mount: CameraMount,
    at_s: float,
    max_age_s: float,
    *,
    vehicle: GeodeticPosition | None = None,
    R_body2ned: NDArray[np.float64] | None = None,
) -> tuple[GeodeticPosition, NDArray[np.float64]]:
    """Return projection centre and ``R_cam2enu``, shape (3, 3), at a time of the track's clock.

    Args:
        track: states that the vehicle has reported.
        mount: mount of the camera.
        at_s: time of exposure.
        max_age_s: largest time between the exposure and the nearest report.
        vehicle: position at exposure, if the vehicle reported it with this exposure; otherwise taken from the track.
        R_body2ned: attitude at exposure, likewise.

    Raises:
        FrameRefusedError: the vehicle or its gimbal did not report within ``max_age_s`` of that time.
    """
    if R_body2ned is None:
        R_body2ned = track.R_body2ned_at(at_s, max_age_s)
    match mount.carrier:
        case Carrier.BODY:
            R_carrier2ned = R_body2ned
        case Carrier.LEVEL:
            R_carrier2ned = R_heading2ned(heading_of(R_body2ned))
        case Carrier.GIMBAL:
            R_carrier2ned = track.R_gimbal2ned_at(at_s, max_age_s)
    position = vehicle if vehicle is not None else track.position_at(at_s, max_age_s)
    return mount.camera_position(position, R_body2ned), mount.R_cam2enu(R_carrier2ned)
