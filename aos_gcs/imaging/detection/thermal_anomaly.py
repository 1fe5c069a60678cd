"""Warm spots in a thermal band, against a background that may change slowly within the frame."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels

BLOCK_PX = 32
"""Edge of the blocks whose medians make up the background: a person fills less than half of one."""

SIGMA_PER_MAD = 1.4826
"""Standard deviation of a Gaussian in units of its median absolute deviation."""


def warm_scores(thermal: Pixels, block_px: int = BLOCK_PX) -> NDArray[np.float32]:
    """Return how much warmer each pixel is than the background, in squares of the robust standard deviation.

    The background is interpolated between medians of blocks, smoothed by a median of 3 x 3 blocks (Bertin and Arnouts,
    *SExtractor*, A&AS 117, 1996). Colder pixels score 0. On a Gaussian background, scores of warmer ones follow a
    chi-square distribution with one degree of freedom.

    Args:
        thermal: one band, shape (H, W), any real type; what is not finite takes no part.
        block_px: edge of the blocks.

    Returns:
        Scores, shape (H, W); NaN where the band is not finite.
    """
    plane = thermal.astype(np.float32)
    finite = np.isfinite(plane)
    if not finite.any():
        return np.full(plane.shape, np.nan, dtype=np.float32)
    # Without the median, 16-bit values keep their digits.
    plane -= np.float32(np.median(plane[finite]))
    residual = plane - _background(plane, finite, block_px)
    sigma = SIGMA_PER_MAD * float(np.median(np.abs(residual[finite])))
    if sigma == 0.0:
        # More than half of the pixels do not differ at all: the others are judged by their own spread.
        sigma = float(residual[finite].std(dtype=np.float64)) or math.inf
    return np.where(finite, np.square(np.maximum(residual / np.float32(sigma), 0.0)), np.float32(np.nan))


def _background(plane: NDArray[np.float32], finite: NDArray[np.bool_], block_px: int) -> NDArray[np.float32]:
    height, width = plane.shape
    rows, columns = max(1, round(height / block_px)), max(1, round(width / block_px))
    row_edges = np.linspace(0, height, rows + 1).astype(int)
    column_edges = np.linspace(0, width, columns + 1).astype(int)
    medians = np.zeros((rows, columns), dtype=np.float32)
    for i in range(rows):
        for j in range(columns):
            block = slice(row_edges[i], row_edges[i + 1]), slice(column_edges[j], column_edges[j + 1])
            known = plane[block][finite[block]]
            # An unknown block takes the median of the frame, which is 0.
            medians[i, j] = np.median(known) if known.size else 0.0
    return np.asarray(cv2.resize(cv2.medianBlur(medians, 3), (width, height), interpolation=cv2.INTER_LINEAR))
