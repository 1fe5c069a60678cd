"""One frame brought to the focal grid, in its own part of the raster only."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focal_plane import MAX_DEPTH_RATIO, covered_spans, grid_to_image, visible_half_planes
from aos_gcs.imaging.model import FocalGrid, Frame, Pixels

_SHIFT_BY_RIM = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
"""Pixels of an image to pixels of the same image with a rim of one pixel."""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The part of a focal grid that one frame covers."""

    row: int
    """Of the grid, where the patch begins."""
    column: int
    covered: NDArray[np.uint8]
    """Shape (rows, columns) of the patch; 1 where the frame covers the centre of the cell."""
    H_patch2image: NDArray[np.float64]
    """Homography from the patch's cells (column, row, 1) to pixels, shape (3, 3)."""

    @property
    def window(self) -> tuple[slice, slice]:
        """Where the patch lies in arrays of the grid's shape."""
        rows, columns = self.covered.shape
        return slice(self.row, self.row + rows), slice(self.column, self.column + columns)


def locate(frame: Frame, grid: FocalGrid) -> Patch | None:
    """Return the part of the grid that the frame covers; None if there is none."""
    H_grid2image = grid_to_image(grid, frame.camera, frame.pose)
    max_depth_m = MAX_DEPTH_RATIO * abs(grid.height_m - float(frame.pose.position_enu_m[2]))
    half_planes = visible_half_planes(H_grid2image, frame.camera, max_depth_m)
    return patch_within(half_planes, H_grid2image, grid.rows, grid.columns)


def patch_within(
    half_planes: NDArray[np.float64], H_raster2image: NDArray[np.float64], rows: int, columns: int
) -> Patch | None:
    """Return the part of a raster inside all half-planes, see :func:`covered_spans`; None if there is none."""
    spans = covered_spans(half_planes, rows, columns)
    covered_rows = np.flatnonzero(spans[:, 1] > spans[:, 0])
    if not covered_rows.size:
        return None
    row = int(covered_rows[0])
    spans = spans[row : covered_rows[-1] + 1]
    column, end = int(spans[:, 0].min()), int(spans[:, 1].max())
    # Comparing short integers takes a third of the time of long ones.
    indices, spans = np.arange(column, end, dtype=np.int32), spans.astype(np.int32)
    covered = ((indices >= spans[:, :1]) & (indices < spans[:, 1:])).view(np.uint8)
    shift = np.array([[1.0, 0.0, column], [0.0, 1.0, row], [0.0, 0.0, 1.0]])
    return Patch(row, column, covered, H_raster2image @ shift)


def warp_image(image: Pixels, patch: Patch) -> tuple[Pixels, NDArray[np.uint8]]:
    """Return the image on the patch, shape (rows, columns, C), and its coverage, shape (rows, columns).

    Bilinear, in the image's own type. Cells that a NaN or infinite pixel has a share in are not covered.
    """
    # A copied rim in place of OpenCV's replicated border: that one is computed for every cell outside the image, too.
    padded = cv2.copyMakeBorder(image, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    warped = _warp(padded, _SHIFT_BY_RIM @ patch.H_patch2image, patch.covered.shape, cv2.INTER_LINEAR)
    return finite_cells(image, warped.reshape(*patch.covered.shape, image.shape[2]), patch.covered)


def finite_cells(image: Pixels, warped: Pixels, covered: NDArray[np.uint8]) -> tuple[Pixels, NDArray[np.uint8]]:
    """Return a warped image and its coverage without the cells that a NaN or infinite pixel has a share in."""
    if image.dtype.kind != "f" or math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0]):
        return warped, covered
    finite = np.asarray(np.isfinite(warped).all(axis=2))
    return np.where(finite[:, :, np.newaxis], warped, 0), covered * finite


def warp_mask(mask: NDArray[np.uint8], patch: Patch) -> NDArray[np.uint8]:
    """Return a mask of an image, shape (H, W), values 0 and 1, on the patch, shape (rows, columns).

    A cell takes the pixel under its centre; in addition, a marked pixel marks the cell under its own centre. The first
    fills the area of pixels larger than cells. The second keeps pixels that no cell's centre falls into, which happens
    at any angle but 0 even where cells are a little smaller than pixels: without it, thin blobs would be torn apart.
    """
    warped = np.asarray(_warp(mask, patch.H_patch2image, patch.covered.shape, cv2.INTER_NEAREST), dtype=np.uint8)
    marked_px = cv2.findNonZero(mask)
    if marked_px is None:
        return warped
    u, v = marked_px.reshape(-1, 2).T
    column, row, inverse_depth = np.linalg.inv(patch.H_patch2image) @ np.stack((u, v, np.ones_like(u)))
    in_front = inverse_depth > 0.0
    columns = np.rint(column[in_front] / inverse_depth[in_front])
    rows = np.rint(row[in_front] / inverse_depth[in_front])
    inside = (rows >= 0) & (rows < warped.shape[0]) & (columns >= 0) & (columns < warped.shape[1])
    warped[rows[inside].astype(np.intp), columns[inside].astype(np.intp)] = 1
    return np.asarray(warped * patch.covered, dtype=np.uint8)


def _warp(image: Pixels, H_raster2image: NDArray[np.float64], shape: tuple[int, ...], interpolation: int) -> Pixels:
    flags = interpolation | cv2.WARP_INVERSE_MAP
    return cv2.warpPerspective(image, H_raster2image, shape[::-1], flags=flags, borderMode=cv2.BORDER_CONSTANT)
