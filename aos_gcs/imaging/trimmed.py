"""Integral images by trimmed mean or median: bright occluders and sun glints do not shine through."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.integral import check_frame
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.views import FocalView
from aos_gcs.imaging.warped import sample

MEDIAN = 0.5
"""The trim that leaves the median."""

DEFAULT_MAX_BYTES = 256_000_000


class Frames(Protocol):
    """Frames that can be counted and gone through several times."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[Frame]: ...


def integrate_trimmed(
    frames: Frames,
    view: FocalView,
    trim: float = MEDIAN,
    *,
    exact: bool = True,
    max_bytes: int = DEFAULT_MAX_BYTES,
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average the middle values of each cell and band.

    Args:
        frames: at least one, all with the same bands. Gone through once per band of rows that fits into the memory, so
            that they may be read anew each time.
        view: see :func:`~aos_gcs.imaging.views.perspective_view` and :func:`~aos_gcs.imaging.views.ortho_view`.
        trim: share of a cell's values left out at either end, from 0 (the mean) to 0.5 (the median).
        exact: see :class:`~aos_gcs.imaging.integral.ViewIntegral`.
        max_bytes: size of the values held at a time; at least one row is held.

    Returns:
        The integral, shape (H, W, C), NaN where nothing covers, and the number of frames that cover each cell, those
        left out included, shape (H, W).

    Raises:
        ImagingError: if there is no frame, or frames differ in their bands.
        ValueError: if ``trim`` does not lie within [0, 0.5].
    """
    if not 0.0 <= trim <= MEDIAN:
        raise ValueError(f"trim must lie within [0, 0.5], got {trim}")
    if not frames:
        raise ImagingError("There is no frame to integrate: give at least one.")
    bands = next(iter(frames)).bands
    rows, columns = view.shape
    integral = np.full((rows, columns, len(bands)), np.nan, dtype=np.float32)
    coverage = np.zeros((rows, columns), dtype=np.uint16)
    step = max(1, max_bytes // (len(frames) * columns * len(bands) * integral.itemsize))
    for first in range(0, rows, step):
        end = min(first + step, rows)
        values, count = _values(frames, view, (first, end), bands, exact=exact)
        coverage[first:end] = count
        integral[first:end] = _middle_mean(values, count, trim)
    return integral, coverage


def _values(
    frames: Frames, view: FocalView, rows: tuple[int, int], bands: tuple[str, ...], *, exact: bool
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Return the values of all frames, shape (n, rows, columns, C), NaN where they do not cover, and the coverage."""
    first, end = rows
    shape = end - first, view.shape[1]
    values = np.full((len(frames), *shape, len(bands)), np.nan, dtype=np.float32)
    coverage = np.zeros(shape, dtype=np.uint16)
    for frame, own in zip(frames, values, strict=True):
        check_frame(frame, bands)
        projection = view.project(frame)
        warped = None if projection is None else sample(frame.image, projection, first, end, exact=exact)
        if warped is not None:
            warped = warped.without_gaps()
            window = slice(warped.window[0].start - first, warped.window[0].stop - first), warped.window[1]
            covered = warped.coverage()
            own[window] = np.where(covered[:, :, np.newaxis] > 0, warped.values, np.nan)
            coverage[window] += covered
    return values, coverage


def _middle_mean(values: NDArray[np.float32], count: NDArray[np.uint16], trim: float) -> NDArray[np.float32]:
    """Return the mean of the sorted values without ``trim`` of the count at either end; sorts in place."""
    # NaN sorts last, so that a cell's values come first.
    values.sort(axis=0)
    known = count.astype(np.int32)
    left_out = np.minimum(np.floor(trim * known).astype(np.int32), np.maximum(known - 1, 0) // 2)
    total = np.zeros(values.shape[1:])
    for index, cells in enumerate(values):
        kept = (index >= left_out) & (index < known - left_out)
        total += np.where(kept[:, :, np.newaxis], cells, 0.0)
    divisor = np.where(known > 0, known - 2.0 * left_out, np.nan)
    return (total / divisor[:, :, np.newaxis]).astype(np.float32)
