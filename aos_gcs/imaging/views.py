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
from aos_gcs.imaging.model import FocalGrid, GroundRaster, Pixels, Viewpoint
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.undistort import RIM_PX, lens_map, sample_pixels, seen_pixels
from aos_gcs.imaging.warp import PlaneProjection
from aos_gcs.imaging.warped import Projection, WarpedFrame, warp_exactly

MIN_DISTANCE_M = 1e-6
"""Smallest distance of a virtual camera to the focal plane; nearer, the plane has no image."""

BLOCK_CELLS = 32
"""Edge of the blocks of cells that are tested as one for whether a frame sees them."""

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


class PointView:
    """A raster whose cells have one point each."""

    def __init__(self, points_m: NDArray[np.float64]) -> None:
        """Take the points of the cells, shape (rows, columns, 3); NaN where there is none."""
        self.shape: tuple[int, int] = (points_m.shape[0], points_m.shape[1])
        known = np.asarray(np.isfinite(points_m).all(axis=2), dtype=np.bool)
        self._known: NDArray[np.uint8] = known.astype(np.uint8)
        self._origin_m = points_m[known].mean(axis=0) if known.any() else np.zeros(3)
        # Relative to their centre, single precision is good for a millionth of the raster's extent.
        self._points_m = np.where(known[:, :, np.newaxis], points_m - self._origin_m, 0.0)
        self._planes32_m = np.ascontiguousarray(np.moveaxis(self._points_m, 2, 0), dtype=np.float32)
        self._lower_m, self._upper_m = _block_bounds(self._points_m, known)

    def project(self, frame: Viewpoint) -> PointProjection | None:
        """See :class:`FocalView`."""
        ideal = frame.camera.ideal()
        R_enu2cam = frame.pose.R_cam2enu.T
        shift_m = R_enu2cam @ (self._origin_m - frame.pose.position_enu_m)
        P = ideal.K @ np.column_stack((R_enu2cam, shift_m))
        window, all_in_front = self._window(visible_half_planes(P, ideal), P[2])
        if window is None:
            return None
        return PointProjection(frame.camera, P, window, all_in_front, self._points_m, self._planes32_m, self._known)

    def _window(
        self, half_spaces: NDArray[np.float64], depth: NDArray[np.float64]
    ) -> tuple[tuple[slice, slice] | None, bool]:
        """Return a window outside of which the frame sees nothing, and whether all in it lies in front of the camera.

        A block of cells is left out only when its bounding box lies wholly outside one of the half-spaces.
        """
        seen = np.isfinite(self._lower_m[..., 0])
        for line in half_spaces:
            seen &= _farthest(line, self._lower_m, self._upper_m) >= 0.0
        block_rows, block_columns = np.nonzero(seen.any(axis=1))[0], np.nonzero(seen.any(axis=0))[0]
        if not block_rows.size:
            return None, True
        blocks = tuple(slice(int(index[0]), int(index[-1]) + 1) for index in (block_rows, block_columns))
        nearest = -_farthest(-depth, self._lower_m[blocks], self._upper_m[blocks])
        rows, columns = (slice(block.start * BLOCK_CELLS, block.stop * BLOCK_CELLS) for block in blocks)
        window = (
            slice(rows.start, min(rows.stop, self.shape[0])),
            slice(columns.start, min(columns.stop, self.shape[1])),
        )
        return window, bool((nearest[np.isfinite(nearest)] > 0.0).all())


@dataclass(frozen=True, slots=True, eq=False)
class PointProjection:
    """See :class:`~aos_gcs.imaging.warped.Projection`."""

    camera: CameraModel
    P: NDArray[np.float64]
    """Projection from points (x, y, z, 1) to homogeneous pixels of the ideal camera, shape (3, 4)."""
    window: tuple[slice, slice]
    """Rows and columns of the raster outside of which the frame sees nothing."""
    all_in_front: bool
    """Every point in the window lies in front of the camera."""
    points_m: NDArray[np.float64]
    """Points of the raster's cells, shape (rows, columns, 3); any numbers where there is none."""
    planes32_m: NDArray[np.float32]
    """Points of the cells at single precision, shape (3, rows, columns)."""
    known: NDArray[np.uint8]
    """1 where a cell has a point, shape (rows, columns)."""

    def sample(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self._band(first_row, end_row)
        if window is None:
            return None
        P = self.P.astype(np.float32)
        planes = P[:, :3] @ self.planes32_m[:, *window].reshape(3, -1) + P[:, 3:]
        u, v, depth = planes.reshape(3, *self.known[window].shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = u / depth, v / depth
        if self.camera.distortion is not None:
            on_map = u + np.float32(RIM_PX), v + np.float32(RIM_PX)
            u, v = (sample_pixels(plane[:, :, np.newaxis], *on_map)[0][:, :, 0] for plane in lens_map(self.camera))
        values, covered = sample_pixels(image, u, v)
        covered &= self.known[window]
        if not self.all_in_front:
            covered &= (depth > 0.0).view(np.uint8)
        return WarpedFrame(window, values, covered)

    def sample_exactly(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self._band(first_row, end_row)
        if window is None:
            return None
        rows, columns = np.nonzero(self.known[window])
        u, v, depth = self.P[:, :3] @ self.points_m[window][rows, columns].T + self.P[:, 3:]
        in_front = depth > 0.0
        pixels = np.stack((u[in_front], v[in_front]), axis=1) / depth[in_front, np.newaxis]
        seen = seen_pixels(pixels, self.camera.ideal())
        cells = rows[in_front][seen], columns[in_front][seen]
        return warp_exactly(image, self.camera, window, cells, pixels[seen])

    def _band(self, first_row: int, end_row: int) -> tuple[slice, slice] | None:
        rows, columns = self.window
        first, end = max(first_row, rows.start), min(end_row, rows.stop)
        return (slice(first, end), columns) if first < end else None


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


def ortho_view(raster: GroundRaster, surface: FocalSurface | float) -> FocalView:
    """Return a map of a focal surface, seen along z; a number is the height of a horizontal plane."""
    shape = raster.rows, raster.columns
    if not isinstance(surface, Terrain):
        plane = surface if isinstance(surface, Plane) else Plane(surface)
        return PlaneView(shape, raster.to_plane, plane, depth_limited=True)
    columns, rows = np.meshgrid(np.arange(raster.columns), np.arange(raster.rows))
    x_m, y_m, _ = np.tensordot(raster.to_plane, np.stack((columns, rows, np.ones_like(rows))), axes=1)
    return PointView(np.dstack((x_m, y_m, surface.z_m(x_m, y_m))))


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


def _block_bounds(
    points_m: NDArray[np.float64], known: NDArray[np.bool]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners of the bounding boxes of square blocks of cells; infinite where a block has no point."""
    cut = [np.arange(0, size, BLOCK_CELLS) for size in known.shape]
    bounds = []
    for function, empty in ((np.minimum, np.inf), (np.maximum, -np.inf)):
        masked = np.where(known[:, :, np.newaxis], points_m, empty)
        bounds.append(function.reduceat(function.reduceat(masked, cut[0], axis=0), cut[1], axis=1))
    return bounds[0], bounds[1]


def _farthest(line: NDArray[np.float64], lower: NDArray[np.float64], upper: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest value of line · (x, y, z, 1) within boxes."""
    corner = np.where(line[:3] > 0.0, upper, lower)
    return np.asarray(np.where(np.isfinite(corner), corner, 0.0) @ line[:3] + line[3])
