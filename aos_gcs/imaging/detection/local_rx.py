"""RX anomaly detection against the surroundings of each pixel, for scenes whose background changes within a frame.

Source: Reed and Yu (see :mod:`aos_gcs.imaging.detection.rx`) with the dual window of Kwon and Nasrabadi, *Kernel
RX-algorithm*, IEEE TGRS 43(2), 2005: statistics come from an outer window without an inner one, which guards them from
the target.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels

GUARD_PX = 33
"""Edge of the inner window: a lying person of 1.8 m seen from 30 m at 512 pixels and 50 degrees, and some more."""

BACKGROUND_PX = 65
"""Edge of the outer window: three times the pixels of the inner one remain."""

LOADING = 1e-3
"""Added to the local variances, in units of the frame's own: what does not vary nearby gives finite scores, and
surroundings are told apart down to a thirtieth of the frame's deviation."""

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
    finite = np.asarray(np.isfinite(image).all(axis=2))
    bands = _standardised(image, finite)
    scores = np.where(finite, np.float32(0.0), np.float32(np.nan))
    if not bands:
        return scores

    def background_sum(plane: NDArray[np.float32]) -> NDArray[np.float32]:
        outer, inner = (_box_sum(plane, edge) for edge in (background_px, guard_px))
        return np.asarray(outer - inner)

    count = background_sum(finite.astype(np.float32))
    enough = finite & (count >= MIN_SAMPLES_PER_BAND * len(bands))
    count = np.maximum(count, 2.0)
    means = [np.asarray(background_sum(band) / count, dtype=np.float32) for band in bands]
    # Cholesky's factor L of the covariance, and the solution of L y = x - mean whose square is the score: row by row,
    # as for one pixel, with an image in place of each number.
    factor: list[list[NDArray[np.float32]]] = []
    solution: list[NDArray[np.float32]] = []
    for i, band in enumerate(bands):
        row: list[NDArray[np.float32]] = []
        residual = band - means[i]
        for j in range(i + 1):
            entry = (background_sum(band * bands[j]) - count * means[i] * means[j]) / (count - 1.0)
            for k in range(j):
                entry -= row[k] * (row[k] if j == i else factor[j][k])
            if j == i:
                row.append(np.sqrt(np.maximum(entry, 0.0) + np.float32(loading)))
            else:
                row.append(entry / factor[j][j])
                residual -= row[j] * solution[j]
        factor.append(row)
        solution.append(residual / row[i])
        scores += np.square(solution[i])
    scores[~enough] = np.nan
    return scores


def _standardised(image: Pixels, finite: NDArray[np.bool_]) -> list[NDArray[np.float32]]:
    """Return the channels that vary, with mean 0 and variance 1; 0 where the image is not finite."""
    bands = []
    for channel in range(image.shape[2]):
        known = image[:, :, channel][finite].astype(np.float64)
        deviation = known.std() if known.size else 0.0
        # Rounding alone makes the deviation of a constant channel differ from 0.
        if deviation > 1e-6 * max(1.0, abs(known.mean()) if known.size else 0.0):
            band = np.zeros(finite.shape, dtype=np.float32)
            band[finite] = (known - known.mean()) / deviation
            bands.append(band)
    return bands


def _box_sum(plane: NDArray[np.float32], edge_px: int) -> NDArray[np.float32]:
    # Beyond the image there is nothing to add.
    return np.asarray(
        cv2.boxFilter(plane, cv2.CV_32F, (edge_px, edge_px), normalize=False, borderType=cv2.BORDER_CONSTANT),
        dtype=np.float32,
    )
