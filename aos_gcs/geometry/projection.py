"""Projection between a camera's pixels and points or planes of its world.

Nothing here assumes that z points up: a plane may lie on either side of the camera, and *in front* always means a
positive depth along the optical axis. ``Pose`` then names the axes of whatever Cartesian world the caller uses.

The homographies follow from x ~ K R^T (X - C) with X = (x, y, z(x, y)) (Hartley and Zisserman, *Multiple View
Geometry*, section 8.1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose


@dataclass(frozen=True, slots=True)
class Plane:
    """The plane z = height_m + slope_x x + slope_y y; vertical ones have no such form."""

    height_m: float
    """z at x = y = 0."""
    slope_x: float = 0.0
    """Change of z per metre along x."""
    slope_y: float = 0.0

    @classmethod
    def through(cls, point_m: ArrayLike, slope_x: float, slope_y: float) -> Plane:
        """Return the plane of these slopes through a point, shape (3,)."""
        x, y, z = (float(value) for value in np.asarray(point_m, dtype=np.float64))
        return cls(z - slope_x * x - slope_y * y, slope_x, slope_y)

    @property
    def normal(self) -> NDArray[np.float64]:
        """Vector at a right angle to the plane, shape (3,), with z = 1; it has not unit length."""
        return np.array([-self.slope_x, -self.slope_y, 1.0])

    def z_m(self, x_m: ArrayLike, y_m: ArrayLike) -> NDArray[np.float64]:
        """Return z at horizontal positions of any shape."""
        return np.asarray(self.height_m + self.slope_x * np.asarray(x_m) + self.slope_y * np.asarray(y_m))

    def gap_m(self, position_m: ArrayLike) -> float:
        """Return how much further along z the plane lies than a point, shape (3,); negative on the other side."""
        x, y, z = np.asarray(position_m, dtype=np.float64)
        return float(self.z_m(x, y) - z)


def as_plane(plane: Plane | float) -> Plane:
    """Return a plane; a number is the height of a horizontal one."""
    return plane if isinstance(plane, Plane) else Plane(plane)


def plane_to_image(camera: CameraModel, pose: Pose, plane: Plane | float) -> NDArray[np.float64]:
    """Return the homography, shape (3, 3), from points (x, y, 1) of a plane to ideal pixels (u, v, 1).

    A number stands for the horizontal plane at that height. The scale is such that the third homogeneous coordinate is
    the depth of the point in metres: positive in front of the camera. It is singular when the plane contains the
    projection centre. Distortion is left out: a camera with it has no homography.
    """
    surface = as_plane(plane)
    x, y, _ = pose.position_enu_m
    gap_m = surface.height_m - float(pose.position_enu_m[2])
    shift = np.array([[1.0, 0.0, -x], [0.0, 1.0, -y], [surface.slope_x, surface.slope_y, gap_m]])
    return np.asarray(camera.K @ pose.R_cam2enu.T @ shift)


def project_points(points_m: ArrayLike, camera: CameraModel, pose: Pose) -> NDArray[np.float64]:
    """Return pixels (u, v), shape (n, 2), of world points, shape (n, 3).

    NaN for points that are not in front of the camera, or too far off the axis for its lens model.
    """
    points_cam = (np.asarray(points_m, dtype=np.float64) - pose.position_enu_m) @ pose.R_cam2enu
    depth_m = points_cam[:, 2:]
    in_front = depth_m > 0.0
    return camera.to_pixels(np.where(in_front, points_cam[:, :2] / np.where(in_front, depth_m, 1.0), np.nan))


def pixel_rays(pixels: ArrayLike, camera: CameraModel, pose: Pose) -> NDArray[np.float64]:
    """Return the directions, shape (n, 3), that pixels (u, v), shape (n, 2), look to; one metre of depth long."""
    normalised = camera.from_pixels(pixels)
    rays_cam = np.column_stack((normalised, np.ones(len(normalised))))
    return np.asarray(rays_cam @ pose.R_cam2enu.T)


def intersect_plane(pixels: ArrayLike, camera: CameraModel, pose: Pose, plane: Plane | float) -> NDArray[np.float64]:
    """Return where the rays of pixels (u, v), shape (n, 2), meet a plane: world points, shape (n, 3).

    A number stands for the horizontal plane at that height. NaN for rays that never meet it in front of the camera.
    """
    surface = as_plane(plane)
    rays = pixel_rays(pixels, camera, pose)
    gap_m = surface.gap_m(pose.position_enu_m)
    approach = rays @ surface.normal
    meets = approach * gap_m > 0.0
    depth_m = np.where(meets, gap_m / np.where(meets, approach, 1.0), np.nan)
    return np.asarray(pose.position_enu_m + depth_m[:, np.newaxis] * rays)
