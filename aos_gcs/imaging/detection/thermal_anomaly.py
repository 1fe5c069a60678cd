"""Warm spots in a thermal band, against a background that may change slowly within the frame."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.scratch import borrow, give_back

BLOCK_PX = 32
"""Edge of the blocks whose medians make up the background: a person fills less than half of one."""

SIGMA_PER_MAD = 1.4826
"""Standard deviation of a Gaussian in units of its median absolute deviation."""


def warm_scores(thermal: Pixels) -> NDArray[np.float32]:
    """Return how much warmer each pixel is than the background, in squares of the robust standard deviation.

    The background is interpolated between medians of blocks, smoothed by a median of 3 x 3 blocks (Bertin and Arnouts,
    *SExtractor*, A&AS 117, 1996). Colder pixels score 0. On a Gaussian background, scores of warmer ones follow a
    chi-square distribution with one degree of freedom.

    Args:
        thermal: one band, shape (H, W), any real type; what is not finite takes no part.

    Returns:
        Scores, shape (H, W); NaN where the band is not finite.
    """
    plane = np.array(thermal, dtype=np.float32, order="C")
    # Few bands have gaps: a sum tells so in a tenth of the time.
    finite = None if math.isfinite(cv2.sumElems(plane)[0]) else np.isfinite(plane)
    if finite is not None and not finite.any():
        return np.full(plane.shape, np.nan, dtype=np.float32)
    memory = borrow(*plane.shape)
    # Without the median, 16-bit values keep their digits.
    plane -= _median(plane, finite, memory)
    residual = np.subtract(plane, _background(plane, finite, memory), out=plane)
    sigma = SIGMA_PER_MAD * float(_median(np.abs(residual, out=memory), finite, memory))
    give_back(memory)
    if sigma == 0.0:
        # More than half of the pixels do not differ at all: the others are judged by their own spread.
        known = residual if finite is None else residual[finite]
        sigma = float(known.std(dtype=np.float64)) or math.inf
    residual /= np.float32(sigma)
    np.maximum(residual, 0.0, out=residual)
    scores = np.square(residual, out=residual)
    if finite is not None:
        scores[~finite] = np.nan
    return scores


def _median(plane: NDArray[np.float32], finite: NDArray[np.bool_] | None, memory: NDArray[np.float32]) -> np.float32:
    """Return the median of the finite values of a plane, in a third of the time of numpy's; memory is overwritten."""
    parted = memory.reshape(-1)
    if finite is None:
        np.copyto(memory, plane)
    else:
        known = plane[finite]
        parted = parted[: known.size]
        parted[:] = known
    middle = parted.size // 2
    parted.partition(middle)
    lower = parted[:middle].max() if parted.size % 2 == 0 else parted[middle]
    return np.float32((lower + parted[middle]) / np.float32(2.0))


def _background(
    plane: NDArray[np.float32], finite: NDArray[np.bool_] | None, memory: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the background of a plane, in some memory of its shape."""
    height, width = plane.shape
    rows, columns = max(1, round(height / BLOCK_PX)), max(1, round(width / BLOCK_PX))
    row_edges = np.linspace(0, height, rows + 1).astype(int)
    column_edges = np.linspace(0, width, columns + 1).astype(int)
    if finite is None:
        medians = _block_medians(plane, row_edges, column_edges, memory)
    else:
        medians = _known_block_medians(plane, finite, row_edges, column_edges)
    smooth = cv2.medianBlur(medians, 3)
    return np.asarray(cv2.resize(smooth, (width, height), dst=memory, interpolation=cv2.INTER_LINEAR))


def _block_medians(
    plane: NDArray[np.float32],
    row_edges: NDArray[np.intp],
    column_edges: NDArray[np.intp],
    memory: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the median of each block: those of equal sizes at once, of which there are four at most."""
    heights, widths = np.diff(row_edges), np.diff(column_edges)
    if np.ptp(heights) == np.ptp(widths) == 0:
        return _medians(plane.reshape(len(heights), heights[0], len(widths), widths[0]), memory)
    medians = np.empty((len(heights), len(widths)), dtype=np.float32)
    for height in np.unique(heights):
        for width in np.unique(widths):
            i, j = np.flatnonzero(heights == height), np.flatnonzero(widths == width)
            # Rows and columns apart: to take single pixels by both takes three times as long.
            rows = np.take(plane, (row_edges[i][:, np.newaxis] + np.arange(height)).reshape(-1), axis=0)
            cells = np.take(rows, (column_edges[j][:, np.newaxis] + np.arange(width)).reshape(-1), axis=1)
            medians[np.ix_(i, j)] = _medians(cells.reshape(len(i), height, len(j), width), memory)
    return medians


def _medians(blocks: NDArray[np.float32], memory: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the medians of blocks, shape (rows, height, columns, width), in some memory that holds them all."""
    rows, height, columns, width = blocks.shape
    own = memory.reshape(-1)[: blocks.size]
    np.copyto(own.reshape(rows, columns, height, width), blocks.swapaxes(1, 2))
    sorted_ = own.reshape(rows, columns, height * width)
    # Short rows are sorted faster than numpy partitions them.
    sorted_.sort(axis=2)
    middle = height * width // 2
    lower = sorted_[:, :, middle - 1] if height * width % 2 == 0 else sorted_[:, :, middle]
    return np.asarray((lower + sorted_[:, :, middle]) / np.float32(2.0))


def _known_block_medians(
    plane: NDArray[np.float32],
    finite: NDArray[np.bool_],
    row_edges: NDArray[np.intp],
    column_edges: NDArray[np.intp],
) -> NDArray[np.float32]:
    """Return the median of the finite values of each block."""
    medians = np.zeros((len(row_edges) - 1, len(column_edges) - 1), dtype=np.float32)
    for i in range(medians.shape[0]):
        for j in range(medians.shape[1]):
            block = slice(row_edges[i], row_edges[i + 1]), slice(column_edges[j], column_edges[j + 1])
            known = plane[block][finite[block]]
            # An unknown block takes the median of the frame, which is 0.
            medians[i, j] = np.median(known) if known.size else 0.0
    return medians
