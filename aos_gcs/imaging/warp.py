"""One frame on a raster of a plane: one homography, in the frame's own part of the raster only."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.focal_plane import covered_spans
from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.undistort import RIM_PX, floats_within, is_floats, lens_map, sample_pixels
from aos_gcs.imaging.warped import WarpedFrame, warp_exactly

_SHIFT_BY_RIM = np.array([[1.0, 0.0, RIM_PX], [0.0, 1.0, RIM_PX], [0.0, 0.0, 1.0]])
"""Ideal pixels to cells of :func:`~aos_gcs.imaging.undistort.lens_map`."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneProjection:
    """See :class:`~aos_gcs.imaging.warped.Projection`."""

    camera: CameraModel
    H_raster2image: NDArray[np.float64]
    """Homography from the raster's cells (column, row, 1) to pixels of the ideal camera, shape (3, 3)."""
    spans: NDArray[np.int32]
    """First column that the frame covers and the one behind the last, per row of the raster, shape (rows, 2)."""
    rows: slice
    """Rows of the raster that the frame covers."""

    @classmethod
    def within(
        cls, half_planes: NDArray[np.float64], camera: CameraModel, H_raster2image: NDArray[np.float64], *shape: int
    ) -> PlaneProjection | None:
        """Return the projection on the part of a raster inside all half-planes; None if there is none.

        Args:
            half_planes: see :func:`~aos_gcs.imaging.focal_plane.covered_spans`.
            camera: camera of the frame.
            H_raster2image: see the field.
            shape: rows and columns of the raster.
        """
        spans = covered_spans(half_planes, *shape)
        covered_rows = np.flatnonzero(spans[:, 1] > spans[:, 0])
        if not covered_rows.size:
            return None
        return cls(camera, H_raster2image, spans, slice(int(covered_rows[0]), int(covered_rows[-1]) + 1))

    def sample(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self.window(first_row, end_row)
        if window is None:
            return None
        covered = self.covered(window)
        if self.camera.distortion is None:
            values = self._warp(*self._seen_part(image, window), window, cv2.INTER_LINEAR)
            return WarpedFrame(window, values.reshape(*values.shape[:2], image.shape[2]), covered)
        values, seen = sample_pixels(image, *self._real_pixels(window))
        return WarpedFrame(window, values, seen if covered is None else seen & covered)

    def sample_exactly(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """See :class:`~aos_gcs.imaging.warped.Projection`."""
        window = self.window(first_row, end_row)
        if window is None:
            return None
        covered = self.covered(window)
        shape = (window[0].stop - window[0].start, window[1].stop - window[1].start)
        rows, columns = np.nonzero(np.ones(shape) if covered is None else covered)
        u, v, w = self.H_from(window) @ np.stack((columns, rows, np.ones_like(rows)))
        return warp_exactly(image, self.camera, window, (rows, columns), np.stack((u / w, v / w), axis=1))

    def sample_mask(self, mask: NDArray[np.uint8], window: tuple[slice, slice]) -> NDArray[np.uint8]:
        """Return what a mask of the image shows under the centres of a window's cells; 0 outside of the image."""
        if self.camera.distortion is None:
            return np.asarray(self._warp(mask, self.H_from(window), window, cv2.INTER_NEAREST), dtype=np.uint8)
        return np.asarray(cv2.remap(mask, *self._real_pixels(window), cv2.INTER_NEAREST), dtype=np.uint8)

    def window(self, first_row: int, end_row: int) -> tuple[slice, slice] | None:
        """Return the smallest part of a band of the raster that holds what the frame covers of it; None if nothing."""
        first, end = max(first_row, self.rows.start), min(end_row, self.rows.stop)
        if first >= end:
            return None
        left, right = int(self.spans[first:end, 0].min()), int(self.spans[first:end, 1].max())
        return (slice(first, end), slice(left, right)) if left < right else None

    def covered(self, window: tuple[slice, slice]) -> NDArray[np.uint8] | None:
        """Return 1 where the frame covers the cells of a window; None if it covers them all."""
        rows, columns = window
        first, end = self.spans[rows, :1], self.spans[rows, 1:]
        if first.max() <= columns.start and end.min() >= columns.stop:
            return None
        indices = np.arange(columns.start, columns.stop, dtype=np.int32)
        return ((indices >= first) & (indices < end)).view(np.uint8)

    def H_from(self, window: tuple[slice, slice]) -> NDArray[np.float64]:
        """Return the homography from a window's own cells to pixels of the ideal camera."""
        shift = np.array([[1.0, 0.0, window[1].start], [0.0, 1.0, window[0].start], [0.0, 0.0, 1.0]])
        return np.asarray(self.H_raster2image @ shift)

    def cells_of(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the cells (column, row) that pixels (u, v) see, shapes (n, 2); NaN where they see none."""
        if self.camera.distortion is not None:
            pixels = self.camera.ideal().to_pixels(self.camera.from_pixels(pixels))
        column, row, inverse_depth = (
            np.linalg.inv(self.H_raster2image) @ np.column_stack((pixels, np.ones(len(pixels)))).T
        )
        inverse_depth = np.where(inverse_depth > 0.0, inverse_depth, np.nan)
        return np.stack((column / inverse_depth, row / inverse_depth), axis=1)

    def _real_pixels(self, window: tuple[slice, slice]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        H = _SHIFT_BY_RIM @ self.H_from(window)
        u, v = (self._warp(plane, H, window, cv2.INTER_LINEAR) for plane in lens_map(self.camera))
        return np.asarray(u, dtype=np.float32), np.asarray(v, dtype=np.float32)

    def _seen_part(self, image: Pixels, window: tuple[slice, slice]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return the part of an image that a window sees, as floats, and the homography from the window to it."""
        H = self.H_from(window)
        if is_floats(image):
            return image.view(np.float32), H
        height, width = window[0].stop - window[0].start, window[1].stop - window[1].start
        u, v, depth = H @ [[0.0, width, 0.0, width], [0.0, 0.0, height, height], [1.0, 1.0, 1.0, 1.0]]
        if depth.min() <= 0.0:
            # The horizon crosses the window.
            return floats_within(image, (0.0, math.inf), (0.0, math.inf))[0], H
        u, v = u / depth, v / depth
        part, left, top = floats_within(image, (u.min(), u.max()), (v.min(), v.max()))
        return part, np.array([[1.0, 0.0, -left], [0.0, 1.0, -top], [0.0, 0.0, 1.0]]) @ H

    @staticmethod
    def _warp(image: Pixels, H: NDArray[np.float64], window: tuple[slice, slice], interpolation: int) -> Pixels:
        rows, columns = window
        size = (columns.stop - columns.start, rows.stop - rows.start)
        border = cv2.BORDER_REPLICATE if interpolation == cv2.INTER_LINEAR else cv2.BORDER_CONSTANT
        return cv2.warpPerspective(image, H, size, flags=interpolation | cv2.WARP_INVERSE_MAP, borderMode=border)
