"""Calls of the compiled kernels with arrays; each says whether the kernel can take what it is given."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.native import library

MOST_BANDS = 8
"""Bands that the kernels of detectors can take."""
_MOST_VALUES = 2**31 - 1
KINDS = {np.dtype(np.uint8): 0, np.dtype(np.uint16): 1, np.dtype(np.float32): 2}
"""Types of pixels, as the kernels number them."""


def can_warp(image: Pixels) -> bool:
    """Tell whether there is a kernel that warps an image, shape (H, W, C)."""
    return (
        library.loaded() is not None
        and image.dtype in KINDS
        and image.flags.c_contiguous
        and min(image.shape[:2]) >= 2
        and image.size <= _MOST_VALUES
    )


def covered_spans(half_planes: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.int32] | None:
    """Return what :func:`~aos_gcs.imaging.focal_plane.covered_spans` does; None where there is no kernel for it."""
    compiled = library.loaded()
    if compiled is None:
        return None
    lines = np.ascontiguousarray(half_planes, dtype=np.float64)
    spans = np.empty((rows, 2), dtype=np.int32)
    compiled.aos_covered_spans(lines.ctypes.data, len(lines), rows, columns, spans.ctypes.data)
    return spans


def count_spans(spans: Sequence[NDArray[np.int32]], rows: int, columns: int) -> NDArray[np.uint16] | None:
    """Return how many spans hold each cell, shape (rows, columns); None where there is no kernel for it.

    Args:
        spans: of each layer the first column and the one behind the last, shape (rows, 2), within the columns.
        rows: rows of the raster.
        columns: its columns.
    """
    compiled = library.loaded()
    if compiled is None:
        return None
    kept = [np.ascontiguousarray(own) for own in spans]
    count = np.zeros((rows, columns), dtype=np.uint16)
    addresses = (ctypes.c_void_p * len(kept))(*(own.ctypes.data for own in kept))
    compiled.aos_add_spans(addresses, len(kept), rows, columns, count.ctypes.data)
    return count


def divide(total: Pixels, count: NDArray[np.uint16], mean: Pixels) -> bool:
    """Divide sums, shape (rows, columns, bands), by numbers of images, NaN where these are 0; False: no kernel does."""
    compiled = library.loaded()
    arrays = total, count, mean
    if compiled is None or total.dtype != np.float32 or not all(array.flags.c_contiguous for array in arrays):
        return False
    compiled.aos_divide(total.ctypes.data, count.ctypes.data, count.size, total.shape[2], mean.ctypes.data)
    return True


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Moments of the pixels of an image whose bands are all finite."""

    mean: NDArray[np.float64]
    """Shape (C,)."""
    covariance: NDArray[np.float64]
    """Covariance with n - 1, shape (C, C)."""


def moments(image: Pixels) -> Moments | None:
    """Return the moments of an image, shape (H, W, C), contiguous; None where there is no kernel for it."""
    compiled = library.loaded()
    bands = image.shape[2]
    if compiled is None or image.dtype not in KINDS or not 0 < bands <= MOST_BANDS or not image.size:
        return None
    sample = image[::16, ::16].reshape(-1, bands)
    sample = sample[np.isfinite(sample).all(axis=1)]
    # Differences from about the mean: single precision then keeps the small ones of 16-bit thermal frames.
    shift = sample.mean(axis=0, dtype=np.float64).astype(np.float32) if sample.size else np.zeros(bands, np.float32)
    sums, products, known = np.zeros(bands), np.zeros((bands, bands)), np.zeros(1, dtype=np.int64)
    compiled.aos_moments(
        image.ctypes.data,
        KINDS[image.dtype],
        image.shape[0] * image.shape[1],
        bands,
        shift.ctypes.data,
        sums.ctypes.data,
        products.ctypes.data,
        known.ctypes.data,
    )
    count = max(int(known[0]), 1)
    products = np.tril(products) + np.tril(products, -1).T
    # Products of large numbers overflow: the covariance then is none.
    with np.errstate(over="ignore", invalid="ignore"):
        return Moments(shift + sums / count, (products - np.outer(sums, sums) / count) / max(count - 1, 1))


def distances(image: Pixels, mean: NDArray[np.float64], whitening: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the squared length of ``whitening @ (pixel - mean)``, shape (H, W); NaN where a band is not finite.

    Args:
        image: an image of which :func:`moments` has returned some.
        mean: shape (C,).
        whitening: lower triangle, shape (C, C).
    """
    compiled = library.loaded()
    if compiled is None:
        raise RuntimeError("The kernels of imaging have not been built.")
    scores = np.empty(image.shape[:2], dtype=np.float32)
    factor, centre = np.ascontiguousarray(whitening, dtype=np.float32), mean.astype(np.float32)
    compiled.aos_distances(
        image.ctypes.data,
        KINDS[image.dtype],
        scores.size,
        image.shape[2],
        centre.ctypes.data,
        factor.ctypes.data,
        scores.ctypes.data,
    )
    return scores


def local_scores(
    bands: NDArray[np.float32],
    finite: NDArray[np.bool_] | None,
    windows_px: tuple[int, int],
    loading: float,
    least: int,
) -> NDArray[np.float32] | None:
    """Return the scores of pixels against their surroundings, shape (H, W); None where there is no kernel for them.

    Args:
        bands: standardised channels, shape (C, H, W), contiguous, 0 where they are not finite.
        finite: pixels that are finite, shape (H, W); None: all of them.
        windows_px: edges of the inner and the outer window, odd.
        loading: addition to the variances.
        least: finite pixels that surroundings need; with fewer the score is NaN.
    """
    compiled = library.loaded()
    if compiled is None or not 0 < len(bands) <= MOST_BANDS:
        return None
    known = None if finite is None else finite.astype(np.float32)
    scores = np.empty(bands.shape[1:], dtype=np.float32)
    failed = compiled.aos_local_scores(
        bands.ctypes.data,
        None if known is None else known.ctypes.data,
        *scores.shape,
        len(bands),
        *windows_px,
        loading,
        least,
        scores.ctypes.data,
    )
    return None if failed else scores
