"""RX anomaly detection against the surroundings of each pixel, for scenes whose background changes within a frame.

Source: Reed and Yu (see :mod:`aos_gcs.imaging.detection.rx`) with the dual window of Kwon and Nasrabadi, *Kernel
RX-algorithm*, IEEE TGRS 43(2), 2005: statistics come from an outer window without an inner one, which guards them from
the target.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.native import kernels
from aos_gcs.imaging.scratch import borrow, give_back

GUARD_PX = 33
"""Edge of the inner window: a lying person of 1.8 m seen from 30 m at 512 pixels and 50 degrees, and some more."""

BACKGROUND_PX = 65
"""Edge of the outer window: three times the pixels of the inner one remain."""

LOADING = 1e-3
"""Added to the local variances, in units of the frame's own: what does not vary nearby gives finite scores, and
surroundings are told apart down to a thirtieth of the frame's deviation."""

_CHUNK_ROWS = 32
"""Rows whose scores are computed at a time: what that takes stays in the cache."""

MIN_SAMPLES_PER_BAND = 10
"""Background pixels that a covariance needs; with fewer there is no score."""


def local_rx_scores(
    image: Pixels, guard_px: int = GUARD_PX, background_px: int = BACKGROUND_PX, loading: float = LOADING
) -> NDArray[np.float32]:
    """Return the squared Mahalanobis distance of each pixel to the mean and covariance (n - 1) of its surroundings.

    Sums over windows come from box filters, so that the time does not depend on their size; windows end with the image.

    Args:
        image: shape (H, W, C), any real type. Pixels with a NaN or infinite channel take no part in the statistics;
            channels that are constant over the frame are left out.
        guard_px: edge of the inner window, odd.
        background_px: edge of the outer window, odd and larger.
        loading: addition to the covariance's diagonal, in units of the variances of the whole frame.

    Returns:
        Scores, shape (H, W); NaN where the pixel is not finite or its surroundings have too few finite pixels.

    Raises:
        ValueError: if an edge is not odd, or the outer window not larger than the inner one.
    """
    if not (guard_px % 2 == background_px % 2 == 1 and 0 < guard_px < background_px):
        raise ValueError(f"windows must be odd, the outer one larger: got {guard_px} in {background_px}")
    finite = _finite(image)
    planes = borrow(image.shape[2], *image.shape[:2])
    scores = _scores_of_bands(_standardised(image, finite, planes), finite, (guard_px, background_px), loading)
    give_back(planes)
    return scores


def local_warm_scores(
    thermal: Pixels, guard_px: int = GUARD_PX, background_px: int = BACKGROUND_PX, loading: float = LOADING
) -> NDArray[np.float32]:
    """Return the scores of :func:`local_rx_scores` where a band is warmer than its surroundings, elsewhere 0.

    Args:
        thermal: one band, shape (H, W), any real type; what is not finite takes no part.
        guard_px: see :func:`local_rx_scores`.
        background_px: the same.
        loading: the same.

    Returns:
        Scores, shape (H, W); NaN as there.
    """
    plane = np.ascontiguousarray(thermal, dtype=np.float32)
    scores = local_rx_scores(plane[:, :, np.newaxis], guard_px, background_px, loading)
    finite = np.isfinite(plane)
    if not finite.all():
        plane = np.where(finite, plane, plane[finite].mean(dtype=np.float64) if finite.any() else 0.0)
    scores[plane < cv2.blur(plane.astype(np.float32, copy=False), (background_px, background_px))] = 0.0
    return scores


def _scores_of_bands(
    bands: NDArray[np.float32], finite: NDArray[np.bool_] | None, windows_px: tuple[int, int], loading: float
) -> NDArray[np.float32]:
    """Return the scores of :func:`local_rx_scores`.

    Args:
        bands: standardised channels, shape (C, H, W), 0 where they are not finite.
        finite: pixels that are finite, shape (H, W); None: all of them.
        windows_px: edges of the inner and the outer window.
        loading: see :func:`local_rx_scores`.
    """
    scores: NDArray[np.float32] = np.zeros(bands.shape[1:], dtype=np.float32)
    if not len(bands):
        return scores if finite is None else np.where(finite, scores, np.float32(np.nan))
    least = MIN_SAMPLES_PER_BAND * len(bands)
    compiled = kernels.local_scores(bands, finite, windows_px, loading, least)
    if compiled is not None:
        return compiled
    guard_px, background_px = windows_px
    inner = np.empty_like(scores)

    def background_sum(plane: NDArray[np.float32]) -> NDArray[np.float32]:
        outer = _box_sum(plane, background_px)
        return np.subtract(outer, _box_sum(plane, guard_px, inner), out=outer)

    count = background_sum(np.ones(scores.shape, np.float32) if finite is None else finite.astype(np.float32))
    enough = count >= least
    if finite is not None:
        enough &= finite
    np.maximum(count, 2.0, out=count)
    sums = [background_sum(band) for band in bands]
    product = np.empty_like(scores)
    products = [
        [background_sum(np.multiply(band, other, out=product)) for other in bands[: i + 1]]
        for i, band in enumerate(bands)
    ]
    for first in range(0, scores.shape[0], _CHUNK_ROWS):
        rows = slice(first, first + _CHUNK_ROWS)
        scores[rows] = _score(
            [band[rows] for band in bands],
            count[rows],
            [total[rows] for total in sums],
            [[total[rows] for total in row] for row in products],
            loading,
        )
    scores[~enough] = np.nan
    return scores


def _score(
    bands: list[NDArray[np.float32]],
    count: NDArray[np.float32],
    sums: list[NDArray[np.float32]],
    products: list[list[NDArray[np.float32]]],
    loading: float,
) -> NDArray[np.float32]:
    """Return the scores of some rows by sums over their surroundings, which are overwritten.

    Args:
        bands: standardised channels.
        count: pixels in the surroundings.
        sums: sums of the channels.
        products: sums of the products of each channel and those up to it.
        loading: see :func:`local_rx_scores`.
    """
    scores, product, degrees = np.zeros_like(count), np.empty_like(count), count - 1.0
    means = [np.divide(total, count, out=total) for total in sums]
    # Cholesky's factor L of the covariance, and the solution of L y = x - mean whose square is the score: row by row,
    # as for one pixel, with an image in place of each number.
    factor: list[list[NDArray[np.float32]]] = []
    solution: list[NDArray[np.float32]] = []
    for i, band in enumerate(bands):
        row: list[NDArray[np.float32]] = []
        residual = band - means[i]
        for j in range(i + 1):
            entry = products[i][j]
            np.multiply(count, means[i], out=product)
            entry -= np.multiply(product, means[j], out=product)
            entry /= degrees
            for k in range(j):
                entry -= np.multiply(row[k], row[k] if j == i else factor[j][k], out=product)
            if j == i:
                np.maximum(entry, 0.0, out=entry)
                entry += np.float32(loading)
                row.append(np.sqrt(entry, out=entry))
            else:
                row.append(np.divide(entry, factor[j][j], out=entry))
                residual -= np.multiply(row[j], solution[j], out=product)
        factor.append(row)
        solution.append(np.divide(residual, row[i], out=residual))
        scores += np.square(solution[i], out=product)
    return scores


def _finite(image: Pixels) -> NDArray[np.bool_] | None:
    """Return which pixels are finite in all channels, shape (H, W); None: all of them, as in most images."""
    if image.dtype.kind in "ui" or math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0]):
        return None
    return np.asarray(np.isfinite(image).all(axis=2))


def _standardised(image: Pixels, finite: NDArray[np.bool_] | None, planes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the channels that vary, shape (C, H, W), with mean 0 and variance 1; 0 where the image is not finite.

    Args:
        image: shape (H, W, C).
        finite: pixels that are finite, shape (H, W); None: all of them.
        planes: memory of the result, with room for all channels.
    """
    known = None if finite is None else finite.view(np.uint8)
    # Bytes are taken apart in a quarter of the memory.
    in_bytes = image.dtype == np.uint8 and image.flags.c_contiguous
    channels = cv2.split(image) if in_bytes else np.moveaxis(image, 2, 0)
    varying = 0
    for channel in channels:
        band = planes[varying]
        values = channel
        if not in_bytes:
            np.copyto(band, channel, casting="same_kind")
            values = band
        mean, deviation = (float(value[0, 0]) for value in cv2.meanStdDev(values, mask=known))
        # Rounding alone makes the deviation of a constant channel differ from 0.
        if deviation > 1e-6 * max(1.0, abs(mean)):
            np.subtract(values, np.float32(mean), out=band, dtype=np.float32)
            band /= np.float32(deviation)
            if finite is not None:
                band[~finite] = 0.0
            varying += 1
    return planes[:varying]


def _box_sum(plane: NDArray[np.float32], edge_px: int, out: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
    # Beyond the image there is nothing to add.
    return np.asarray(
        cv2.boxFilter(plane, cv2.CV_32F, (edge_px, edge_px), out, normalize=False, borderType=cv2.BORDER_CONSTANT),
        dtype=np.float32,
    )
