"""Virtual rasters over a focal surface, and how frames are brought to them.

A raster is what a virtual camera sees, or a map of the ground in metres. On a plane every frame reaches it through one
homography; on terrain each of its cells has a point of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane, pixel_rays, plane_to_image
from aos_gcs.imaging.focal_plane import MAX_DEPTH_RATIO, visible_half_planes
from aos_gcs.imaging.model import Frame, GroundRaster, Pixels
from aos_gcs.imaging.terrain import Terrain
from aos_gcs.imaging.undistort import RIM_PX, remap, seen_pixels, undistorted
from aos_gcs.imaging.warp import finite_cells, patch_within, warp_image

MIN_DISTANCE_M = 1e-6
"""Of a virtual camera to the focal plane; nearer, the plane has no image."""

BLOCK_CELLS = 32
"""Edge of the blocks of cells that are tested as one for whether a frame sees them."""

_SHIFT_BY_RIM = np.array([[1.0, 0.0, RIM_PX], [0.0, 1.0, RIM_PX], [0.0, 0.0, 1.0]])

FocalSurface: TypeAlias = Plane | Terrain


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """One frame on a part of a raster."""

    window: tuple[slice, slice]
    """Rows and columns of the raster that the part takes up."""
    values: Pixels
    """float64 if exact, else float32; shape (rows, columns, C); of no meaning where nothing covers."""
    covered: NDArray[np.uint8]
    """1 where the frame covers the cell, shape (rows, columns)."""


class FocalView(Protocol):
    """A raster on a focal surface."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""

    def warp(self, frame: Frame, *, exact: bool) -> Layer | None:
        """Return the frame on its part of the raster; None where it sees nothing of it.

        Exact: bilinear at double precision, through the lens in one step. Otherwise OpenCV's single precision (before
        OpenCV 5: coordinates in steps of 1/32 pixel), distorted frames by way of their ideal camera.
        """

    def rows(self, first: int, end: int) -> FocalView:
        """Return a band of the raster."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneView:
    """A raster on a plane."""

    shape: tuple[int, int]
    H_raster2plane: NDArray[np.float64]
    """From cells (column, row, 1) to points (x, y, 1); its third coordinate is positive where there is a point."""
    plane: Plane
    depth_limited: bool
    """Leave out what frames see at more than ``MAX_DEPTH_RATIO``; needs a homography that is affine."""

    def warp(self, frame: Frame, *, exact: bool) -> Layer | None:
        """See :class:`FocalView`."""
        ideal = frame.camera.ideal()
        H_raster2image = plane_to_image(ideal, frame.pose, self.plane) @ self.H_raster2plane
        distance_m = abs(self.plane.gap_m(frame.pose.position_enu_m))
        max_depth_m = MAX_DEPTH_RATIO * distance_m if self.depth_limited else math.inf
        half_planes = np.vstack((visible_half_planes(H_raster2image, ideal, max_depth_m), self.H_raster2plane[2]))
        patch = patch_within(half_planes, H_raster2image, *self.shape)
        if patch is None:
            return None
        if not exact:
            values, covered = warp_image(_as_float32(undistorted(frame).image), patch)
            return Layer(patch.window, values, covered)
        rows, columns = np.nonzero(patch.covered)
        u, v, w = patch.H_patch2image @ np.stack((columns, rows, np.ones_like(rows)))
        pixels = np.stack((u / w, v / w), axis=1)
        return _exact_layer(frame, patch.window, (rows, columns), pixels, patch.covered.shape)

    def rows(self, first: int, end: int) -> PlaneView:
        """See :class:`FocalView`."""
        shift = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, first], [0.0, 0.0, 1.0]])
        return PlaneView((end - first, self.shape[1]), self.H_raster2plane @ shift, self.plane, self.depth_limited)


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
        self._points32_m = self._points_m.astype(np.float32)
        self._lower_m, self._upper_m = _block_bounds(self._points_m, known)

    def warp(self, frame: Frame, *, exact: bool) -> Layer | None:
        """See :class:`FocalView`."""
        ideal = frame.camera.ideal()
        R_enu2cam = frame.pose.R_cam2enu.T
        shift_m = R_enu2cam @ (self._origin_m - frame.pose.position_enu_m)
        P = ideal.K @ np.column_stack((R_enu2cam, shift_m))
        window, all_in_front = self._window(visible_half_planes(P, ideal), P[2])
        if window is None:
            return None
        if exact:
            return self._warp_exactly(frame, window, R_enu2cam, shift_m)
        points = np.ascontiguousarray(self._points32_m[window])
        pixels = np.asarray(cv2.perspectiveTransform(points, _SHIFT_BY_RIM @ P), dtype=np.float32)
        first, (right, bottom) = RIM_PX - 0.5, np.array([ideal.width_px, ideal.height_px]) + RIM_PX - 0.5
        in_image = cv2.inRange(pixels, (first, first), (right, bottom))
        covered = np.asarray(in_image, dtype=np.uint8) & self._known[window]
        if not all_in_front:
            covered &= (points @ P[2, :3].astype(np.float32) > -P[2, 3]).astype(np.uint8)
        image = _as_float32(undistorted(frame).image)
        warped = remap(image, pixels)
        return Layer(window, *finite_cells(image, warped, covered))

    def rows(self, first: int, end: int) -> PointView:
        """See :class:`FocalView`."""
        known = self._known[first:end, :, np.newaxis] > 0
        return PointView(np.where(known, self._points_m[first:end] + self._origin_m, np.nan))

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

    def _warp_exactly(
        self,
        frame: Frame,
        window: tuple[slice, slice],
        R_enu2cam: NDArray[np.float64],
        shift_m: NDArray[np.float64],
    ) -> Layer:
        rows, columns = np.nonzero(self._known[window])
        points_cam = self._points_m[window][rows, columns] @ R_enu2cam.T + shift_m
        in_front = points_cam[:, 2] > 0.0
        rows, columns, points_cam = rows[in_front], columns[in_front], points_cam[in_front]
        ideal = frame.camera.ideal()
        pixels = ideal.to_pixels(points_cam[:, :2] / points_cam[:, 2:])
        shape = self._known[window].shape
        seen = seen_pixels(pixels, ideal)
        return _exact_layer(frame, window, (rows[seen], columns[seen]), pixels[seen], shape)


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


def _exact_layer(
    frame: Frame,
    window: tuple[slice, slice],
    cells: tuple[NDArray[np.intp], NDArray[np.intp]],
    ideal_pixels: NDArray[np.float64],
    shape: tuple[int, ...],
) -> Layer:
    """Sample a frame at pixels of its ideal camera, shape (n, 2), for cells of a window: clamped at the border."""
    rows, columns = cells
    pixels = ideal_pixels
    if frame.camera.distortion is not None:
        pixels = frame.camera.to_pixels(frame.camera.ideal().from_pixels(ideal_pixels))
        seen = seen_pixels(pixels, frame.camera)
        rows, columns, pixels = rows[seen], columns[seen], pixels[seen]
    # OpenCV's warps quantise the coordinate to 1/32 pixel before version 5; this one does not.
    samples = np.stack(
        [
            map_coordinates(frame.image[:, :, channel], pixels[:, ::-1].T, output=np.float64, order=1, mode="nearest")
            for channel in range(frame.image.shape[2])
        ],
        axis=1,
    )
    finite = np.isfinite(samples).all(axis=1)
    rows, columns = rows[finite], columns[finite]
    values = np.zeros((*shape, samples.shape[1]))
    covered = np.zeros(shape, dtype=np.uint8)
    values[rows, columns] = samples[finite]
    covered[rows, columns] = 1
    return Layer(window, values, covered)


def _as_float32(image: Pixels) -> NDArray[np.float32]:
    # Bytes would be rounded to whole grey levels by every single warp, and OpenCV is no faster with them.
    return image.astype(np.float32, copy=False)


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
