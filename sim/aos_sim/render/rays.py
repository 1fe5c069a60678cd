"""Rays through pixels, and what they span on the ground."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.world.mesh import FloatArray

MIN_DEPTH_M = 0.1


def ray_directions(pose: Pose, camera: CameraModel) -> FloatArray:
    """Directions through the pixel centres in ENU, row by row, shape (H * W, 3), with one metre along the axis."""
    return image_rays(pose, camera).reshape(-1, 3)


def image_rays(pose: Pose, camera: CameraModel, stride: int = 1) -> FloatArray:
    """Directions as of :func:`ray_directions`, of every ``stride``-th pixel of every such row, shape (h, w, 3)."""
    # A product of matrices takes twenty times as long where BLAS hands it to several threads.
    return np.asarray(cv2.transform(_camera_rays(camera, stride), pose.R_cam2enu.astype(np.float32)), dtype=np.float32)


@lru_cache(maxsize=8)
def _camera_rays(camera: CameraModel, stride: int) -> FloatArray:
    u, v = np.meshgrid(np.arange(0, camera.width_px, stride), np.arange(0, camera.height_px, stride))
    x, y = (u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px
    rays = np.dstack([x, y, np.ones_like(x)]).astype(np.float32)
    rays.flags.writeable = False
    return rays


def pixel_rays(pixels: NDArray[np.intp], pose: Pose, camera: CameraModel) -> FloatArray:
    """Directions as of :func:`ray_directions`, through pixels given by their flat indices, shape (n, 3)."""
    if not len(pixels):
        return np.empty((0, 3), np.float32)
    chosen = _camera_rays(camera, 1).reshape(-1, 1, 3)[pixels]
    return np.asarray(cv2.transform(chosen, pose.R_cam2enu.astype(np.float32)), dtype=np.float32).reshape(-1, 3)


def pixels_around(points_enu_m: NDArray[np.floating], pose: Pose, camera: CameraModel) -> NDArray[np.intp]:
    """Flat indices of the pixels that can show anything of the convex hull of some points, shape (n, 3).

    All pixels when a part of the hull lies beside or behind the camera, where it has no image.
    """
    x, y, depth = ((points_enu_m - pose.position_enu_m) @ pose.R_cam2enu).T
    if np.all(depth < MIN_DEPTH_M):
        return np.empty(0, np.intp)
    if np.any(depth < MIN_DEPTH_M):
        return np.arange(camera.width_px * camera.height_px)
    u, v = camera.fx_px * x / depth + camera.cx_px, camera.fy_px * y / depth + camera.cy_px
    columns = np.arange(max(int(u.min()), 0), min(int(u.max()) + 1, camera.width_px - 1) + 1)
    rows = np.arange(max(int(v.min()), 0), min(int(v.max()) + 1, camera.height_px - 1) + 1)
    return np.asarray((rows[:, None] * camera.width_px + columns).ravel(), dtype=np.intp)
