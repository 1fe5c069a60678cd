"""Integral of a step's frames on the raster of its focal plane."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.integral import BATCH_FRAMES, ViewIntegral, integrate_batch
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.native.kernels import can_warp
from aos_gcs.imaging.scratch import borrow, give_back
from aos_gcs.imaging.undistort import is_floats
from aos_gcs.imaging.views import grid_view
from aos_gcs.imaging.workers import parallel_map


@dataclass(frozen=True, slots=True, eq=False)
class StepIntegral:
    """The mean of a step's frames on the focal plane."""

    mean: NDArray[np.float32]
    """Shape (rows, columns, C), NaN where nothing covers."""
    coverage: NDArray[np.uint16]
    """Number of frames that cover each cell, shape (rows, columns)."""


def integrate(frames: Sequence[Frame], grid: FocalGrid, shape: tuple[int, int] | None = None) -> StepIntegral:
    """Average usable frames on the focal plane, a batch at a time so that memory does not grow with their number.

    Args:
        frames: usable frames of a step.
        grid: raster of the focal plane.
        shape: rows and columns of a coarser raster of the same extent; None: those of the grid.
    """
    view, width_px = grid_view(grid), 1
    if shape is not None and shape != view.shape:
        rows_each, columns_each = view.shape[0] / shape[0], view.shape[1] / shape[1]
        to_grid = np.array(
            [[columns_each, 0.0, (columns_each - 1) / 2], [0.0, rows_each, (rows_each - 1) / 2], [0.0, 0.0, 1.0]]
        )
        view = replace(view, shape=shape, H_raster2plane=view.H_raster2plane @ to_grid)
        width_px = 2 * int(min(rows_each, columns_each) / 2) + 1
    batches = [frames[first : first + BATCH_FRAMES] for first in range(0, len(frames), BATCH_FRAMES)]
    integral = ViewIntegral(view, frames[0].bands, exact=False)
    for batch in batches:
        with _converted(batch, width_px) as converted:
            if len(batches) == 1:
                return StepIntegral(*integrate_batch(converted, view, exact=False))
            integral.add_all(converted)
    return StepIntegral(*integral.take())


@contextmanager
def _converted(frames: Sequence[Frame], width_px: int) -> Iterator[Sequence[Frame]]:
    """Provide frames in single precision, in memory that others get afterwards."""
    converted = parallel_map(partial(_in_single_precision, width_px=width_px), frames)
    yield converted
    for frame, own in zip(frames, converted, strict=True):
        if own.image is not frame.image:
            give_back(own.image.view(np.float32))


def _in_single_precision(frame: Frame, width_px: int) -> Frame:
    """Return the frame with its whole image converted, so that bands of the raster do not convert parts of it again.

    What the compiled kernel takes as it is stays as it is, unless it is averaged.

    Pixels are averaged over a square of an odd width, for cells that are larger than pixels; not in images with gaps,
    which OpenCV's running sums would spread.
    """
    image = frame.image
    if width_px == 1 and can_warp(image):
        return frame
    if not is_floats(image):
        image = borrow(*image.shape)
        np.copyto(image, frame.image)
    if width_px > 1 and math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0]):
        blurred = cv2.blur(image, (width_px, width_px), dst=borrow(*image.shape)).reshape(image.shape)
        if image is not frame.image:
            give_back(image.view(np.float32))
        image = np.asarray(blurred, dtype=np.float32)
    return replace(frame, image=image)
