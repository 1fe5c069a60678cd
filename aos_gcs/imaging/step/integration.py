"""Integral of a step's frames on the raster of its focal plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.integral import BATCH_FRAMES, ViewIntegral
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.views import grid_view
from aos_gcs.imaging.workers import parallel_map


@dataclass(frozen=True, slots=True, eq=False)
class StepIntegral:
    """The mean of a step's frames on the focal plane."""

    mean: NDArray[np.float32]
    """Shape (rows, columns, C), NaN where nothing covers."""
    coverage: NDArray[np.uint16]
    """Number of frames that cover each cell, shape (rows, columns)."""


def integrate(frames: Sequence[Frame], grid: FocalGrid) -> StepIntegral:
    """Average usable frames on the focal plane, a batch at a time so that memory does not grow with their number."""
    integral = ViewIntegral(grid_view(grid), frames[0].bands, exact=False)
    for first in range(0, len(frames), BATCH_FRAMES):
        integral.add_all(parallel_map(_in_single_precision, frames[first : first + BATCH_FRAMES]))
    return StepIntegral(*integral.take())


def _in_single_precision(frame: Frame) -> Frame:
    """Return the frame with its whole image converted, so that bands of the raster do not convert parts of it again."""
    return replace(frame, image=np.ascontiguousarray(frame.image, dtype=np.float32))
