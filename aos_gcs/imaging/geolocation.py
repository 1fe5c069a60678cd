"""Geolocation: position of the target behind a blob, with its covariance.

Every frame that marks a blob gives one line of sight. The target is where the lines meet, near the focal plane: a
generalised least-squares intersection with a prior on the height of what is seen. A blob's plain centroid lacks the
height: a standing person's body hides ground *behind* its feet as seen from the camera, by height / flying height of
the horizontal distance, so that a swarm on one side of the target would see it displaced.

The noise of each line follows from the uncertainty of its camera's pose through the Jacobian of the intersection
with the focal plane, to first order (Hartley and Zisserman, *Multiple View Geometry*, section 5.2). With the ray
r = x - C from the camera to the point and its oblique projection P = I - r e_z^T / r_z onto the plane,

    dx = P dC - P [r]_x dphi + |r_z| P (R K^-1 dp) / d_z' + (r / r_z) dh

for errors of position, orientation (a small rotation about ENU axes), pixel and height of the plane. What stays of an
error of orientation stays in the camera's axes, as that of a mount does: it points elsewhere once the vehicle has
turned, and views of opposite headings tell it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import BlobView
from aos_gcs.imaging.surfaces.terrain import Terrain

_GROUND_ROUNDS = 6
"""Rounds in which the place of a target and the height of the ground there come to agree: on a slope of 50 %, seen 30
degrees off the nadir, each leaves less than a third of the difference."""
_LEAST_DEPTH_M = 1.0
"""Height above the ground from which a camera sees it."""


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """Standard deviations of what a position is computed from.

    Raises:
        ConfigurationError: a value is negative or not finite, or the target has no extent; the text names it.
    """

    position_horizontal_m: float = 0.5
    """Error of a camera's position at exposure, along each axis; about 0.02 with RTK."""
    position_vertical_m: float = 1.0
    attitude_rad: float = math.radians(1.0)
    """Error of the tilt of a camera about either axis of its image."""
    yaw_rad: float = math.radians(3.0)
    """Error of its rotation about its optical axis."""
    clock_s: float = 0.03
    """Error of the time of exposure, for frames that do not tell their own; matters for cameras that move."""
    persistent_share: float = 0.8
    """Share of the variance of position and orientation that stays with a vehicle from frame to frame, as biases of
    receivers, compasses and camera mounts do, so that averaging over steps does not reduce it."""
    pixel_px: float = 1.0
    """Error of a blob's place in an image: quantisation and calibration."""
    focal_height_m: float = 1.0
    """Error of the ground's height at the target; common to all vehicles."""
    target_height_m: float = 0.6
    """Mean height above the ground of the part of a target that is seen: persons stand, sit and lie."""
    target_height_sigma_m: float = 0.4
    target_extent_m: float = 0.2
    """Along each horizontal axis, of the visible part about the middle of the body, different in every frame as leaves
    hide another part of it; and of that middle about the person's position, for a sitting one has its legs ahead."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ConfigurationError(f"{entry.name} must be a finite number not below 0, but is {value}.")
        if self.persistent_share > 1.0:
            raise ConfigurationError(f"persistent_share must lie within 0 and 1, but is {self.persistent_share}.")
        if self.target_extent_m == 0.0:
            raise ConfigurationError("target_extent_m must be above 0: no target is a point.")


@dataclass(frozen=True, slots=True, eq=False)
class Geolocation:
    """A position in the mission's ENU frame with its error, in two parts.

    The covariance of one estimate is the sum of both. Over several estimates of one swarm only the first averages out.
    """

    position_enu_m: NDArray[np.float64]
    """Position of the ground below the target, shape (3,)."""
    random_m2: NDArray[np.float64]
    """Covariance of what changes from frame to frame, shape (3, 3), ENU."""
    systematic_m2: NDArray[np.float64]
    """Covariance of what stays: biases of poses, the height of the ground, that of the target."""

    @property
    def covariance_m2(self) -> NDArray[np.float64]:
        """Covariance of the position, shape (3, 3), ENU."""
        return np.asarray(self.random_m2 + self.systematic_m2)


def geolocate(
    views: Sequence[BlobView],
    plane_height_m: float,
    uncertainty: Uncertainty,
    ground: Terrain | None = None,
) -> Geolocation:
    """Return the position of the target that these views show.

    Args:
        views: one per frame that marks the blob, at least one. Frames of one vehicle share its biases.
        plane_height_m: ENU height of the focal plane that the views' points lie on; the ground, but for an error.
        uncertainty: see :class:`Uncertainty`.
        ground: see :func:`locate_together`.

    Raises:
        ImagingError: if there is no view.
    """
    return locate_together([views], plane_height_m, uncertainty, ground=ground)[0]


def locate_together(
    targets: Sequence[Sequence[BlobView]],
    plane_height_m: float,
    uncertainty: Uncertainty,
    speed_mps: float = 0.0,
    ground: Terrain | None = None,
) -> tuple[Geolocation, ...]:
    """Return where several targets stand, better than one by one where vehicles see more than one of them.

    A pose's error displaces whatever the vehicle sees: the other targets tell how far its lines of sight lie from those
    of the other vehicles, and, as they lie elsewhere in the image, its heading. The mean error of the swarm remains.

    Args:
        targets: per target the views of it, at least one; otherwise as in :func:`geolocate`.
        plane_height_m: ENU height of the focal plane.
        uncertainty: see :class:`Uncertainty`. Heights are taken as independent from target to target.
        speed_mps: how fast cameras may have moved at exposure, in any horizontal direction, where views do not tell
            more.
        ground: the ground in view, where it is known: targets stand on it, whatever the height of the focal plane.

    Raises:
        ImagingError: if a target has no view.
    """
    if not all(targets):
        raise ImagingError("There is no view of the target to locate it from.")
    if not targets:
        return ()
    views = [view for own in targets for view in own]
    target_of_view = np.repeat(np.arange(len(targets)), [len(own) for own in targets])
    cameras_m = np.array([view.pose.position_enu_m for view in views])
    rays_m = np.column_stack([[view.point_enu_m for view in views], np.full(len(views), plane_height_m)]) - cameras_m
    heights_m = np.full(len(targets), plane_height_m)
    if ground is not None:
        heights_m = _heights_below(ground, cameras_m, rays_m, target_of_view, plane_height_m)
        rays_m *= ((heights_m[target_of_view] - cameras_m[:, 2]) / rays_m[:, 2])[:, np.newaxis]
    points_m = (cameras_m + rays_m)[:, :2]
    white_m2, persistent_m2 = _noise_m2(views, target_of_view, rays_m, uncertainty, speed_mps)
    # A view of the point (x, y) at z above the plane meets the plane at (x, y) - slope z.
    blocks = np.zeros((len(views), 2, len(targets), 3))
    blocks[np.arange(len(views)), :, target_of_view, :2] = np.eye(2)
    blocks[np.arange(len(views)), :, target_of_view, 2] = -rays_m[:, :2] / rays_m[:, 2:]
    design = blocks.reshape(2 * len(views), 3 * len(targets))
    weighted = np.linalg.solve(white_m2 + persistent_m2, design).T
    # The height of what is seen above the plane: that of the body above the ground, and the plane's own error.
    height_m2 = uncertainty.target_height_sigma_m**2 + uncertainty.focal_height_m**2
    prior_information = np.tile([0.0, 0.0, 1.0 / max(height_m2, 1e-12)], len(targets))
    covariance_m2 = np.asarray(np.linalg.inv(weighted @ design + np.diag(prior_information)), dtype=np.float64)
    gain = covariance_m2 @ weighted
    prior_m = covariance_m2 @ (prior_information * uncertainty.target_height_m)
    seen_enu_m = (gain @ points_m.ravel() + prior_m).reshape(-1, 3)
    random_m2 = gain @ white_m2 @ gain.T
    rows_of_target = [slice(3 * target, 3 * target + 3) for target in range(len(targets))]
    return tuple(
        _on_ground(seen_m, covariance_m2[own, own], random_m2[own, own], float(height_m), uncertainty)
        for seen_m, own, height_m in zip(seen_enu_m, rows_of_target, heights_m, strict=True)
    )


def _heights_below(
    ground: Terrain,
    cameras_m: NDArray[np.float64],
    rays_m: NDArray[np.float64],
    target_of_view: NDArray[np.intp],
    plane_height_m: float,
) -> NDArray[np.float64]:
    """Return the height of the ground where the lines of sight to each target meet it, shape (targets,).

    Where it is not known, or not below the cameras, the height is that of the focal plane.
    """
    counts = np.bincount(target_of_view)
    lowest_camera_m = np.full(len(counts), np.inf)
    np.minimum.at(lowest_camera_m, target_of_view, cameras_m[:, 2])
    heights_m = np.full(len(counts), plane_height_m)
    for _ in range(_GROUND_ROUNDS):
        shares = (heights_m[target_of_view] - cameras_m[:, 2]) / rays_m[:, 2]
        points_m = cameras_m[:, :2] + shares[:, np.newaxis] * rays_m[:, :2]
        east_m, north_m = (np.bincount(target_of_view, along_m) / counts for along_m in points_m.T)
        below_m = ground.z_m(east_m, north_m)
        heights_m = np.where(below_m < lowest_camera_m - _LEAST_DEPTH_M, below_m, plane_height_m)
    return heights_m


def _on_ground(
    seen_enu_m: NDArray[np.float64],
    covariance_m2: NDArray[np.float64],
    random_m2: NDArray[np.float64],
    plane_height_m: float,
    uncertainty: Uncertainty,
) -> Geolocation:
    """Return the place of the ground below a point (x, y, height above the plane) where a target was seen."""
    height_m2 = uncertainty.target_height_sigma_m**2 + uncertainty.focal_height_m**2
    ground_share = uncertainty.focal_height_m**2 / max(height_m2, 1e-12)
    to_ground = np.array([1.0, 1.0, ground_share])
    random_m2, total_m2 = (np.outer(to_ground, to_ground) * part for part in (random_m2, covariance_m2))
    total_m2[[0, 1], [0, 1]] += uncertainty.target_extent_m**2
    total_m2[2, 2] += uncertainty.focal_height_m**2 * (1.0 - ground_share)
    east_m, north_m, seen_at_m = seen_enu_m
    up_m = plane_height_m + ground_share * (seen_at_m - uncertainty.target_height_m)
    return Geolocation(np.array([east_m, north_m, up_m]), random_m2, total_m2 - random_m2)


def pose_jacobian(ray_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how a point on a horizontal plane moves with errors of its camera's pose, shape (2, 6).

    Args:
        ray_m: from the camera to the point, ENU, shape (3,).

    Returns:
        Derivatives of (x, y) with respect to the camera's position (3, metres) and to a small rotation of the camera
        about the ENU axes (3, radians).
    """
    P = _onto_plane(ray_m)
    x, y, z = ray_m
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.hstack((P, -P @ cross))


def pixel_jacobian(ray_m: NDArray[np.float64], camera: CameraModel, pose: Pose) -> NDArray[np.float64]:
    """Return how a point on a horizontal plane moves with its ideal pixel (u, v), shape (2, 2), metres per pixel."""
    depth_m = float(ray_m @ pose.R_cam2enu[:, 2])
    per_pixel = pose.R_cam2enu[:, :2] / [camera.fx_px, camera.fy_px]
    return np.asarray(depth_m * _onto_plane(ray_m) @ per_pixel)


def _onto_plane(ray_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the projection along a ray onto the horizontal plane, shape (2, 3)."""
    return np.column_stack((np.eye(2), -ray_m[:2] / ray_m[2]))


def _noise_m2(
    views: Sequence[BlobView],
    target_of_view: NDArray[np.intp],
    rays_m: NDArray[np.float64],
    uncertainty: Uncertainty,
    speed_mps: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the covariances of all points, shape (2 n, 2 n): of what changes per frame, of what stays per vehicle."""
    pose_sigmas = np.array(
        [uncertainty.position_horizontal_m] * 2
        + [uncertainty.position_vertical_m]
        + [uncertainty.attitude_rad] * 2
        + [uncertainty.yaw_rad]
    )
    scaled = np.vstack(
        [pose_jacobian(ray_m) @ _in_camera(view.pose) * pose_sigmas for view, ray_m in zip(views, rays_m, strict=True)]
    )
    pose_m2 = scaled @ scaled.T
    frame_of_view = _frames(views, target_of_view)
    # What one frame shows of two targets is displaced together.
    together = frame_of_view[:, np.newaxis] == frame_of_view
    white_m2 = _per_axis(together) * (1.0 - uncertainty.persistent_share) * pose_m2
    for i, (view, ray_m) in enumerate(zip(views, rays_m, strict=True)):
        own = slice(2 * i, 2 * i + 2)
        per_pixel_m = pixel_jacobian(ray_m, view.camera, view.pose) * uncertainty.pixel_px
        clock_s = uncertainty.clock_s if view.time_sigma_s is None else view.time_sigma_s
        moved_m = max(speed_mps, view.speed_mps) * clock_s
        own_m2 = uncertainty.target_extent_m**2 + moved_m**2
        white_m2[own, own] += per_pixel_m @ per_pixel_m.T + own_m2 * np.eye(2)
    vehicle_ids = np.array([view.vehicle_id for view in views])
    same_vehicle = vehicle_ids[:, np.newaxis] == vehicle_ids
    return white_m2, _per_axis(same_vehicle) * uncertainty.persistent_share * pose_m2


def _in_camera(pose: Pose) -> NDArray[np.float64]:
    """Return what takes errors of a position in ENU and a rotation about the camera's axes to ENU, shape (6, 6)."""
    to_enu = np.eye(6)
    to_enu[3:, 3:] = pose.R_cam2enu
    return to_enu


def _frames(views: Sequence[BlobView], target_of_view: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return a number per view, shape (n,), that those of one frame share: no frame has two views of one target.

    A vehicle that stays where it is may take several frames with the same pose.
    """
    counts: Counter[tuple[tuple[float, ...], int]] = Counter()
    keys = []
    for view, target in zip(views, target_of_view, strict=True):
        exposure = (view.vehicle_id, *view.pose.position_enu_m)
        keys.append((*exposure, counts[exposure, int(target)]))
        counts[exposure, int(target)] += 1
    return np.asarray(np.unique(keys, axis=0, return_inverse=True)[1].ravel(), dtype=np.intp)


def _per_axis(related: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a relation between views, shape (n, n), as one between their coordinates, shape (2 n, 2 n)."""
    return related.repeat(2, axis=0).repeat(2, axis=1)
