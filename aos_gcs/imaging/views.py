"""Virtual rasters over a focal surface, and how frames are brought to them.

A raster is what a virtual camera sees, or a map of the ground in metres. On a plane every frame reaches it through one
homography; on terrain each of its cells has a point of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane, pixel_rays, plane_to_image
from aos_gcs.imaging.focal_plane import MAX_DEPTH_RATIO, grid_to_plane, visible_half_planes
from aos_gcs.imaging.model import FocalGrid, MapRaster, Viewpoint
from aos_gcs.imaging.points import PointView
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.warp import PlaneProjection
from aos_gcs.imaging.warped import Projection

MIN_DISTANCE_M = 1e-6
"""Smallest distance of a virtual camera to the focal plane; nearer, the plane has no image."""

FocalSurface: TypeAlias = Plane | Terrain


class FocalView(Protocol):
    """A raster on a focal surface."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""

    def project(self, frame: Viewpoint) -> Projection | None:
        """Return where the frame lies on the raster; None if nowhere."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneView:
    """A raster on a plane."""

    shape: tuple[int, int]
    H_raster2plane: NDArray[np.float64]
    """Homography from cells (column, row, 1) to points (x, y, 1); its third coordinate is positive at a point."""
    plane: Plane
    depth_limited: bool
    """Leave out what frames see at more than ``MAX_DEPTH_RATIO``; needs a homography that is affine."""

    def project(self, frame: Viewpoint) -> PlaneProjection | None:
        """See :class:`FocalView`."""
        ideal = frame.camera.ideal()
        H_raster2image = plane_to_image(ideal, frame.pose, self.plane) @ self.H_raster2plane
        max_depth_m = math.inf
        if self.depth_limited:
            max_depth_m = MAX_DEPTH_RATIO * abs(self.plane.gap_m(frame.pose.position_enu_m))
        half_planes = np.vstack((visible_half_planes(H_raster2image, ideal, max_depth_m), self.H_raster2plane[2]))
        return PlaneProjection.within(half_planes, frame.camera, H_raster2image, *self.shape)


def perspective_view(camera: CameraModel, pose: Pose, surface: FocalSurface | float) -> FocalView:
    """Return what a virtual camera sees of a focal surface; a number is the height of a horizontal plane.

    Raises:
        ImagingError: if the virtual camera does not have the surface in front of it, or is distorted.
    """
    if camera.distortion is not None:
        raise ImagingError("A virtual camera has no distortion: give it an ideal one.")
    shape = camera.height_px, camera.width_px
    if not isinstance(surface, Terrain):
        plane = surface if isinstance(surface, Plane) else Plane(surface)
        return PlaneView(shape, _view_to_plane(camera, pose, plane), plane, depth_limited=False)
    u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    rays = pixel_rays(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose)
    points = surface.intersect(pose.position_enu_m, rays)
    if not np.isfinite(points).any():
        raise ImagingError(
            "The virtual camera sees nothing of the terrain: check that the terrain lies in front of it, in the same "
            "world as the poses."
        )
    return PointView(points.reshape(*shape, 3))


def ortho_view(raster: MapRaster, surface: FocalSurface | float) -> FocalView:
    """Return a map of a focal surface, seen along z; a number is the height of a horizontal plane."""
    shape = raster.rows, raster.columns
    if not isinstance(surface, Terrain):
        plane = surface if isinstance(surface, Plane) else Plane(surface)
        return PlaneView(shape, raster.to_plane, plane, depth_limited=True)
    x_m = raster.to_plane[0, 0] * np.arange(raster.columns) + raster.to_plane[0, 2]
    y_m = (raster.to_plane[1, 1] * np.arange(raster.rows) + raster.to_plane[1, 2])[:, np.newaxis]
    return PointView(np.dstack((*np.broadcast_arrays(x_m, y_m), surface.z_m(x_m, y_m))))


def grid_view(grid: FocalGrid) -> PlaneView:
    """Return the raster of a focal grid."""
    return PlaneView((grid.rows, grid.columns), grid_to_plane(grid), Plane(grid.height_m), depth_limited=True)


def _view_to_plane(camera: CameraModel, pose: Pose, plane: Plane) -> NDArray[np.float64]:
    """Return the homography from pixels to the plane, its third coordinate positive where the plane is in front."""
    name = f"The focal plane z = {plane.height_m:g} m"
    if abs(plane.gap_m(pose.position_enu_m)) < MIN_DISTANCE_M:
        raise ImagingError(f"{name} passes through the virtual camera: choose one in front of it.")
    # (x, y, 1) = depth · H⁻¹ (u, v, 1): the third coordinate of H⁻¹ (u, v, 1) is 1 / depth.
    H_view2plane = np.linalg.inv(plane_to_image(camera, pose, plane))
    corners = np.array([[-0.5, camera.width_px - 0.5], [-0.5, camera.height_px - 0.5]])
    inverse_depths = [H_view2plane[2] @ (u, v, 1.0) for u in corners[0] for v in corners[1]]
    if max(inverse_depths) <= 0.0:
        raise ImagingError(
            f"{name} lies behind the virtual camera at z = {float(pose.position_enu_m[2]):.1f} m: choose a plane on "
            "the side that the camera looks to."
        )
    return np.asarray(H_view2plane)
