"""Projection between a camera's pixels and points or horizontal planes of its world.

Nothing here assumes that z points up: a plane z = h may lie on either side of the camera, and *in front* always means a
positive depth along the optical axis. ``Pose`` then names the axes of whatever Cartesian world the caller uses.

The homographies follow from x ~ K R^T (X - C) with X = (x, y, h) (Hartley and Zisserman, *Multiple View Geometry*,
section 8.1).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose


def plane_to_image(camera: CameraModel, pose: Pose, plane_height_m: float) -> NDArray[np.float64]:
    """Return the homography, shape (3, 3), from points (x, y, 1) of the plane z = height to pixels (u, v, 1).

    Its scale is such that the third homogeneous coordinate is the depth of the point in metres: positive in front of
    the camera. It is singular when the plane contains the projection centre.
    """
    x, y, z = pose.position_enu_m
    shift = np.array([[1.0, 0.0, -x], [0.0, 1.0, -y], [0.0, 0.0, plane_height_m - z]])
    return np.asarray(camera.K @ pose.R_cam2enu.T @ shift)


def project_points(points_m: ArrayLike, camera: CameraModel, pose: Pose) -> NDArray[np.float64]:
    """Return pixels (u, v), shape (n, 2), of world points, shape (n, 3); NaN for points not in front of the camera."""
    points_cam = (np.asarray(points_m, dtype=np.float64) - pose.position_enu_m) @ pose.R_cam2enu
    depth_m = points_cam[:, 2:]
    in_front = depth_m > 0.0
    pixels = (points_cam / np.where(in_front, depth_m, 1.0)) @ camera.K.T
    return np.where(in_front, pixels[:, :2], np.nan)


def intersect_plane(pixels: ArrayLike, camera: CameraModel, pose: Pose, plane_height_m: float) -> NDArray[np.float64]:
    """Return where the rays of pixels (u, v), shape (n, 2), meet the plane z = height: world points, shape (n, 3).

    NaN for rays that never meet it in front of the camera.
    """
    u, v = np.asarray(pixels, dtype=np.float64).T
    rays_cam = np.stack(((u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px, np.ones_like(u)), axis=1)
    rays = rays_cam @ pose.R_cam2enu.T
    rise_m = plane_height_m - pose.position_enu_m[2]
    meets = rays[:, 2] * rise_m > 0.0
    depth_m = np.where(meets, rise_m / np.where(meets, rays[:, 2], 1.0), np.nan)
    return np.asarray(pose.position_enu_m + depth_m[:, np.newaxis] * rays)
