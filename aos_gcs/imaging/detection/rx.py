"""Reed-Xiaoli anomaly detection on single frames (spec, section 2).

Source: Reed and Yu, *Adaptive multiple-band CFAR detection of an optical pattern with unknown spectral distribution*,
IEEE TASSP 38(10), 1990, with the global mean and covariance of the frame.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.native import kernels
from aos_gcs.imaging.scratch import borrow, give_back

CHUNK_PIXELS = 1 << 14
"""Pixels worked on at a time: four float32 planes of them stay in the L2 cache, and partial sums keep their digits."""

MIN_PIVOT = 1e-2
"""Smallest diagonal element of the correlation matrix's Cholesky factor that float32 sums support to about 1 %."""

MIN_EIGENVALUE = 1e-9
"""Smallest eigenvalue of the correlation matrix in float64; what varies less is the rounding of float32 pixels."""

ROUNDING_VARIANCE = 1.0 / 12.0
"""Variance of what rounding to whole numbers takes from a value."""

_SAMPLE_PX = 16
"""Every so many pixels of every so many rows tell whether a channel was rounded."""

FALSE_ALARM_PROBABILITY = 1e-9
"""Probability that one pixel of a Gaussian background is marked, see :func:`default_min_score`."""

TAIL_MARGIN = 2.5
"""Factor on the Gaussian's limit, see :func:`default_min_score`."""


def rx_scores(image: Pixels) -> NDArray[np.float32]:
    """Return the squared Mahalanobis distance of each pixel to the frame's own mean and covariance (n - 1).

    Constant and linearly dependent channels carry no information of their own and are left out (pseudo-inverse), so a
    frame without any variation scores 0 everywhere. What channels of whole numbers tell varies by at least what
    rounding takes: of colours by night, two or three of 255 levels, a pixel that differs by one would stand out.

    Args:
        image: shape (H, W, C), any real type that float32 can hold. Pixels with a NaN or infinite channel take no part
            in the statistics.

    Returns:
        Scores, shape (H, W); NaN where the pixel is not finite. On a Gaussian background they follow a chi-square
        distribution with C degrees of freedom.
    """
    whole = _whole_channels(image)
    scores = _compiled_scores(image, whole)
    if scores is not None:
        return scores
    height, width, channels = image.shape
    planes = borrow(channels, height, width)
    if image.dtype == np.uint8 and image.flags.c_contiguous:
        # A quarter of the memory to be taken apart.
        split = cv2.split(image)
        means = [cv2.mean(plane)[0] for plane in split]
        for plane, values, mean in zip(planes, split, means, strict=True):
            np.subtract(values, np.float32(mean), out=plane, dtype=np.float32)
        scores = _scores_of_planes(planes.reshape(channels, -1), height * width, whole)
        give_back(planes)
        return scores.reshape(height, width)
    # Into memory at hand: touching new memory takes longer than the work.
    cv2.split(np.ascontiguousarray(image, dtype=np.float32), list(planes))
    means = [cv2.mean(plane)[0] for plane in planes]
    unknown = np.empty(0, dtype=np.intp)
    if not np.isfinite(means).all():
        # A list, as gaps are small: masks would be gone through once for each plane and use.
        unknown = _unknown(planes.reshape(channels, -1))
        # As zeros they add nothing to any sum.
        planes.reshape(channels, -1)[:, unknown] = 0.0
        means = [cv2.mean(plane)[0] * height * width / max(height * width - unknown.size, 1) for plane in planes]
    for plane, mean in zip(planes, means, strict=True):
        # Centring comes first: float32 then keeps the small differences of 16-bit thermal frames.
        np.subtract(plane, np.float32(mean), out=plane)
    rows = planes.reshape(channels, -1)
    rows[:, unknown] = 0.0
    scores = _scores_of_planes(rows, height * width - unknown.size, whole)
    give_back(planes)
    scores[unknown] = np.nan
    return scores.reshape(height, width)


def _whole_channels(image: Pixels) -> NDArray[np.intp]:
    """Return the indices of the channels that have whole numbers alone, as far as a sample tells."""
    sample = image[::_SAMPLE_PX, ::_SAMPLE_PX].reshape(-1, image.shape[2])
    return np.flatnonzero(((sample == np.rint(sample)) | ~np.isfinite(sample)).all(axis=0))


def _with_rounding(covariance: NDArray[np.float64], whole: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return a covariance, shape (C, C), in which no combination of whole channels varies less than rounding does."""
    block = np.ix_(whole, whole)
    if not np.isfinite(covariance[block]).all():
        return covariance
    variances, directions = np.linalg.eigh(covariance[block])
    missing = np.maximum(ROUNDING_VARIANCE - variances, 0.0)
    if not missing.any():
        return covariance
    rounded = covariance.copy()
    rounded[block] += (directions * missing) @ directions.T
    return rounded


def _compiled_scores(image: Pixels, whole: NDArray[np.intp]) -> NDArray[np.float32] | None:
    """Return the scores by the compiled kernels; None where there are none, or channels depend on each other."""
    image = np.ascontiguousarray(image)
    moments = kernels.moments(image)
    whitening = None if moments is None else _cholesky_whitening(_with_rounding(moments.covariance, whole))
    if moments is None or whitening is None:
        return None
    return kernels.distances(image, moments.mean, whitening)


def _unknown(planes: NDArray[np.float32]) -> NDArray[np.intp]:
    """Return the indices of the pixels of planes, shape (C, n), that have a NaN or infinite channel."""
    with np.errstate(invalid="ignore", over="ignore"):
        total = planes[0] if len(planes) == 1 else planes[0] + planes[1]
        for plane in planes[2:]:
            total += plane
    # Sums of finite numbers may overflow.
    suspects = np.flatnonzero(~np.isfinite(total))
    return np.asarray(suspects[~np.isfinite(planes[:, suspects]).all(axis=0)], dtype=np.intp)


def anomaly_mask(scores: NDArray[np.float32], quantile: float = 0.9998, min_score: float = 0.0) -> NDArray[np.uint8]:
    """Mark the pixels whose score lies in the top ``1 - quantile`` of the frame and above ``min_score``.

    The quantile alone marks the same number of pixels in every frame, also where there is nothing to find; the absolute
    limit leaves an empty frame (almost) unmarked.

    Args:
        scores: shape (H, W); NaN is never marked.
        quantile: within [0, 1).
        min_score: see :func:`default_min_score`.

    Returns:
        Mask, shape (H, W), 1 where marked and 0 elsewhere.
    """
    candidates = scores[scores > min_score]
    allowed = round((1.0 - quantile) * np.count_nonzero(~np.isnan(scores)))
    if allowed == 0:
        return np.zeros(scores.shape, dtype=np.uint8)
    if candidates.size <= allowed:
        return (scores > min_score).astype(np.uint8)
    # Only the candidates need to be partitioned: the quantile's threshold is one of them.
    threshold = np.partition(candidates, candidates.size - allowed)[candidates.size - allowed]
    return np.asarray(scores >= threshold, dtype=np.uint8)


@cache
def default_min_score(channels: int) -> float:
    """Return a score that background pixels practically never exceed (120 for four channels, 93 for one).

    A Gaussian background exceeds its chi-square quantile in one pixel of about 4,000 frames of 512 x 512; the margin on
    top is for the heavier tails of forests: rendered ones without a person reach 2.1 times the quantile, persons in
    them 15 to 30 times.
    """
    return TAIL_MARGIN * float(scipy.special.chdtri(channels, FALSE_ALARM_PROBABILITY))


def _scores_of_planes(planes: NDArray[np.float32], known: int, whole: NDArray[np.intp]) -> NDArray[np.float32]:
    """Score centred pixels, shape (C, n), of which ``known`` are measured and the others 0; returns shape (n,)."""
    whitening = _whitening(planes, known, whole).astype(np.float32)
    scores = np.zeros(planes.shape[1], dtype=np.float32)
    for start in range(0, planes.shape[1], CHUNK_PIXELS):
        whitened = whitening @ planes[:, start : start + CHUNK_PIXELS]
        np.einsum("ij,ij->j", whitened, whitened, out=scores[start : start + CHUNK_PIXELS])
    return scores


def _whitening(planes: NDArray[np.float32], known: int, whole: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return W, shape (rank, C), with W^T W the (pseudo-)inverse of the covariance of centred pixels, shape (C, n)."""
    whitening = _cholesky_whitening(_with_rounding(_covariance(planes, known, np.float32), whole))
    if whitening is not None:
        return whitening
    return _pseudo_whitening(_with_rounding(_covariance(planes, known, np.float64), whole))


def _cholesky_whitening(covariance: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return a lower triangle W with W^T W the inverse of a covariance; None where single precision does not do."""
    if not (np.diag(covariance) > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(np.diag(covariance))
    try:
        # Correlations have one scale whatever the channels' units are, so that one limit fits all.
        factor = np.linalg.cholesky(covariance * np.outer(scale, scale))
    except np.linalg.LinAlgError:
        return None
    return np.asarray(np.linalg.inv(factor) * scale) if np.diag(factor).min() > MIN_PIVOT else None


def _covariance(
    planes: NDArray[np.float32], known: int, dtype: type[np.float32] | type[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance (n - 1) of centred pixels; products are summed in ``dtype`` within a chunk."""
    channels, pixels = planes.shape
    covariance = np.zeros((channels, channels))
    for start in range(0, pixels, CHUNK_PIXELS):
        chunk: Pixels = planes[:, start : start + CHUNK_PIXELS].astype(dtype, copy=False)
        covariance += chunk @ chunk.T
    return np.asarray(covariance / max(known - 1, 1))


def _pseudo_whitening(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    deviations = np.sqrt(np.diag(covariance))
    scale = 1.0 / np.where(deviations > 0.0, deviations, 1.0)
    eigenvalues, eigenvectors = np.linalg.eigh(covariance * np.outer(scale, scale))
    kept = eigenvalues > MIN_EIGENVALUE
    return np.asarray((eigenvectors[:, kept] / np.sqrt(eigenvalues[kept])).T * scale)
