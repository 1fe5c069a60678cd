"""Frames warped onto a part of a raster, and how they are sampled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.undistort import seen_pixels


@dataclass(frozen=True, slots=True, eq=False)
class WarpedFrame:
    """One frame on a part of a raster."""

    window: tuple[slice, slice]
    """Rows and columns of the raster that the part takes up."""
    values: Pixels
    """float64 if exact, else float32; shape (rows, columns, C); of no meaning where nothing covers."""
    covered: NDArray[np.uint8] | None
    """1 where the frame covers the cell, shape (rows, columns); None: it covers all."""

    def coverage(self) -> NDArray[np.uint8]:
        """Return ``covered``, written out."""
        return np.ones(self.values.shape[:2], dtype=np.uint8) if self.covered is None else self.covered

    def without_gaps(self) -> WarpedFrame:
        """Return the frame without the cells that a NaN or infinite pixel has a share in."""
        cells = self.values.reshape(-1, self.values.shape[2])
        # One product in place of a reduction over a very short axis, which is ten times as slow.
        finite = np.isfinite(cells @ np.ones(cells.shape[1], dtype=cells.dtype)).reshape(self.values.shape[:2])
        if finite.all():
            return self
        # OpenCV's masked sum of a single channel would let through what is not finite.
        values = self.values.copy()
        values[~finite] = 0.0
        return WarpedFrame(self.window, values, finite.view(np.uint8) & self.coverage())


class Projection(Protocol):
    """Projection of one frame onto a raster; its image is an argument of each call."""

    def sample(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """Return the image on a band of the raster, bilinear at single precision; None where it covers nothing.

        Cells that a NaN or infinite pixel has a share in are still in it.
        """

    def sample_exactly(self, image: Pixels, first_row: int, end_row: int) -> WarpedFrame | None:
        """Return the image on a band of the raster, bilinear at double precision; None where it covers nothing."""


def sample(image: Pixels, projection: Projection, first_row: int, end_row: int, *, exact: bool) -> WarpedFrame | None:
    """Return an image on a band of a raster, at double precision if ``exact``, else at single precision."""
    return (projection.sample_exactly if exact else projection.sample)(image, first_row, end_row)


def warp_exactly(
    image: Pixels,
    camera: CameraModel,
    window: tuple[slice, slice],
    cells: tuple[NDArray[np.intp], NDArray[np.intp]],
    ideal_pixels: NDArray[np.float64],
) -> WarpedFrame:
    """Sample an image at pixels of its ideal camera, shape (n, 2), for cells of a window: clamped at the border."""
    rows, columns = cells
    pixels = ideal_pixels
    if camera.distortion is not None:
        pixels = camera.to_pixels(camera.ideal().from_pixels(ideal_pixels))
        seen = seen_pixels(pixels, camera)
        rows, columns, pixels = rows[seen], columns[seen], pixels[seen]
    # OpenCV's warps quantise coordinates to 1/32 pixel before version 5; this function does not.
    samples = np.stack(
        [
            scipy.ndimage.map_coordinates(
                image[:, :, channel], pixels[:, ::-1].T, output=np.float64, order=1, mode="nearest"
            )
            for channel in range(image.shape[2])
        ],
        axis=1,
    )
    finite = np.isfinite(samples).all(axis=1)
    rows, columns = rows[finite], columns[finite]
    shape = (window[0].stop - window[0].start, window[1].stop - window[1].start)
    values = np.zeros((*shape, samples.shape[1]))
    covered = np.zeros(shape, dtype=np.uint8)
    values[rows, columns] = samples[finite]
    covered[rows, columns] = 1
    return WarpedFrame(window, values, covered)
