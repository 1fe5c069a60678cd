"""Rasters whose cells have one point each, as those of terrain have, and how frames are brought to them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.focal_plane import visible_half_planes
from aos_gcs.imaging.model import Pixels, Viewpoint
from aos_gcs.imaging.undistort import RIM_PX, lens_map, sample_pixels, seen_pixels
from aos_gcs.imaging.warped import WarpedFrame, warp_exactly

BLOCK_CELLS = 32
"""Edge of the blocks of cells that are tested as one for whether a frame sees them, as in ``points.c``."""

MIN_DEPTH_M = 1e-6
"""Smallest depth of a point in front of a camera, as in ``points.c``: nearer ones have no pixel."""


class PointView:
    """A raster whose cells have one point each."""

    def __init__(self, points_m: NDArray[np.float64]) -> None:
        """Take the points of the cells, shape (rows, columns, 3); NaN where there is none."""
        self.shape: tuple[int, int] = (points_m.shape[0], points_m.shape[1])
        # Sums in place of reductions over a very short axis, which are many times as slow.
        known = np.asarray(np.isfinite(points_m.sum(axis=2)), dtype=np.bool)
        origin_m = np.array(
            [np.mean(points_m[:, :, axis], where=known) for axis in range(3)] if known.any() else [0.0] * 3
        )
        # Relative to their centre, single precision is good for a millionth of the raster's extent.
        points32_m = (points_m - origin_m).astype(np.float32)
        if not known.all():
            points32_m[~known] = 0.0
        self._points = CellPoints(points_m, origin_m, points32_m, known.astype(np.uint8))
        self._lower_m, self._upper_m = _block_bounds(points32_m, known)

    def project(self, frame: Viewpoint) -> PointProjection | None:
        """See :class:`~aos_gcs.imaging.views.FocalView`."""
        ideal = frame.camera.ideal()
        R_enu2cam = frame.pose.R_cam2enu.T
        shift_m = R_enu2cam @ (self._points.origin_m - frame.pose.position_enu_m)
        P = ideal.K @ np.column_stack((R_enu2cam, shift_m))
        seen = self._seen_blocks(visible_half_planes(P, ideal))
        if not seen.any():
            return None
        nearest_m = -_farthest(-P[2], self._lower_m[seen], self._upper_m[seen])
        return PointProjection(frame.camera, P, seen, bool((nearest_m > MIN_DEPTH_M).all()), self._points)

    def _seen_blocks(self, half_spaces: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which blocks the frame may see: one is left out only when its box lies wholly outside a half-space."""
        seen = np.isfinite(self._lower_m[..., 0])
        for line in half_spaces:
            seen &= _farthest(line, self._lower_m, self._upper_m) >= 0.0
        return seen


@dataclass(frozen=True, slots=True, eq=False)
class CellPoints:
    """The points of a raster's cells."""

    points_m: NDArray[np.float64]
    """Shape (rows, columns, 3); NaN where there is none."""
    origin_m: NDArray[np.float64]
    """A point near all of them, shape (3,)."""
    points32_m: NDArray[np.float32]
    """Points relative to the origin at single precision, shape (rows, columns, 3); 0 where there is none."""
    known: NDArray[np.uint8]
    """1 where a cell has a point, shape (rows, columns)."""


@dataclass(frozen=True, slots=True, eq=False)
class PointProjection:
    """See :class:`~aos_gcs.imaging.warped.Projection`."""

    camera: CameraModel
    P: NDArray[np.float64]
    """Projection from points (x, y, z, 1), relative to their origin, to homogeneous pixels of the ideal camera, shape
    (3, 4)."""
    seen_blocks: NDArray[np.bool_]
    """Blocks of the raster's cells outside of which the frame sees nothing."""
    all_in_front: bool
    """Every point in these blocks lies in front of the camera."""
    points: CellPoints

    def sample(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self._window(first_row, end_row)
        if window is None:
            return None
        points32_m, known = self.points.points32_m[window], self.points.known[window]
        # Two planes: OpenCV samples images of several channels by them in half the time.
        u, v = (
            np.asarray(plane, dtype=np.float32) for plane in cv2.split(cv2.perspectiveTransform(points32_m, self.P))
        )
        if self.camera.distortion is not None:
            on_map = u + np.float32(RIM_PX), v + np.float32(RIM_PX)
            u, v = (sample_pixels(plane[:, :, np.newaxis], *on_map)[0][:, :, 0] for plane in lens_map(self.camera))
        values, covered = sample_pixels(image, u, v)
        covered &= known
        if not self.all_in_front:
            depth_m = points32_m @ self.P[2, :3].astype(np.float32) + np.float32(self.P[2, 3])
            covered &= (depth_m > MIN_DEPTH_M).view(np.uint8)
        return WarpedFrame(window, values, covered)

    def sample_exactly(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self._window(first_row, end_row)
        if window is None:
            return None
        rows, columns = np.nonzero(self.points.known[window])
        points_m = self.points.points_m[window][rows, columns] - self.points.origin_m
        u, v, depth = self.P[:, :3] @ points_m.T + self.P[:, 3:]
        in_front = depth > 0.0
        pixels = np.stack((u[in_front], v[in_front]), axis=1) / depth[in_front, np.newaxis]
        seen = seen_pixels(pixels, self.camera.ideal())
        cells = rows[in_front][seen], columns[in_front][seen]
        return warp_exactly(image, self.camera, window, cells, pixels[seen])

    def _window(self, first_row: int, end_row: int) -> tuple[slice, slice] | None:
        """Return the smallest part of a band of rows that holds the blocks seen there; None if there is none."""
        rows, columns = self.points.known.shape
        end_row = min(end_row, rows)
        seen = self.seen_blocks[first_row // BLOCK_CELLS : -(-end_row // BLOCK_CELLS)]
        in_rows, in_columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        if not in_rows.size:
            return None
        first_block = first_row // BLOCK_CELLS
        top = max(first_row, (first_block + int(in_rows[0])) * BLOCK_CELLS)
        bottom = min(end_row, (first_block + int(in_rows[-1]) + 1) * BLOCK_CELLS)
        left, right = int(in_columns[0]) * BLOCK_CELLS, min(columns, (int(in_columns[-1]) + 1) * BLOCK_CELLS)
        return slice(top, bottom), slice(left, right)


def _block_bounds(
    points_m: NDArray[np.float32], known: NDArray[np.bool]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners of the bounding boxes of square blocks of cells, infinite where a block has no point."""
    rows, columns = (-(-size // BLOCK_CELLS) for size in known.shape)
    padding = [(0, rows * BLOCK_CELLS - known.shape[0]), (0, columns * BLOCK_CELLS - known.shape[1])]
    bounds = []
    for function, empty in ((np.min, np.inf), (np.max, -np.inf)):
        planes = []
        for axis in range(3):
            plane = np.where(known, points_m[:, :, axis], np.float32(empty))
            padded = np.pad(plane, padding, constant_values=empty)
            planes.append(function(padded.reshape(rows, BLOCK_CELLS, columns, BLOCK_CELLS), axis=(1, 3)))
        bounds.append(np.stack(planes, axis=2).astype(np.float64))
    return bounds[0], bounds[1]


def _farthest(line: NDArray[np.float64], lower: NDArray[np.float64], upper: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest value of line · (x, y, z, 1) within boxes."""
    corner = np.where(line[:3] > 0.0, upper, lower)
    return np.asarray(np.where(np.isfinite(corner), corner, 0.0) @ line[:3] + line[3])
