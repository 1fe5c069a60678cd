"""Agreement of frames on a focal surface: the measure that autofocus maximises.

On the surface that a thing lies on, all frames show it at the same place; elsewhere parallax scatters it. The mean
correlation of all pairs of frames says so, in contrast to the sharpness of the integral: what hides the ground in one
frame only, or makes all frames brighter, does not change it, 0 means chance, and its scatter by chance is known. All
pairs of n frames cost no more than n frames, as sum_{i != j} f_i f_j = (sum f_i)^2 - sum f_i^2.
"""

from __future__ import annotations

import math
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.rx import anomaly_mask, rx_scores
from aos_gcs.imaging.model import Pixels

FINE_SIGMA_PX = 1.0
COARSE_SIGMA_PX = 6.0
"""Standard deviations of the difference of Gaussians: finer structure is noise, coarser one says little about the
height."""

CORRELATION_AREA_PX = 4.0 * math.pi * FINE_SIGMA_PX**2
"""Pixels of a filtered frame that vary together."""

MAX_GROUPS = 16
"""Groups of cameras that are told apart."""

RX_QUANTILE = 0.998
"""Quantile of a frame's scores: ten times as many marks as detection allows, as chance ones do not agree on any
height."""


class FocusSignal(StrEnum):
    """Property of the frames that must agree."""

    TEXTURE = "texture"
    """All structure: the surface comes into focus that has most of it in view, which may be the canopy."""
    ANOMALY = "anomaly"
    """Only what the RX detector marks: warm or colourful targets, wherever they are."""


def focus_signal(image: Pixels, signal: FocusSignal, reduction: int = 1) -> NDArray[np.float32]:
    """Return what is compared of a frame: its band-passed channels, or its band-passed anomaly mask.

    Args:
        image: shape (H, W, C), any real type.
        signal: property of the frames to compare.
        reduction: edge of the square blocks of pixels that are averaged first; structure is then as much coarser.

    Returns:
        Shape (ceil(H / reduction), ceil(W / reduction), C), or 1 in place of C for a mask; NaN where the image is.
    """
    if signal is FocusSignal.ANOMALY:
        scores = rx_scores(image)
        mask = anomaly_mask(scores, RX_QUANTILE).astype(np.float32)
        image = np.where(np.isnan(scores), np.float32(np.nan), mask)[:, :, np.newaxis]
    rows, columns = math.ceil(image.shape[0] / reduction), math.ceil(image.shape[1] / reduction)
    planes = [_band_pass(image[:, :, channel], (columns, rows)) for channel in range(image.shape[2])]
    return np.stack(planes, axis=2)


class CameraGroups:
    """Groups of cameras that are at least some distance apart, formed in the order in which cameras are added."""

    def __init__(self, separation_m: float) -> None:
        self._separation_m = separation_m
        self._first_m: list[NDArray[np.float64]] = []

    def add(self, position_m: NDArray[np.float64]) -> int:
        """Return the group of a camera: the nearest within the separation, or a new one while there may be more."""
        distances_m = [float(np.linalg.norm(position_m - first_m)) for first_m in self._first_m]
        nearest = int(np.argmin(distances_m)) if distances_m else 0
        is_new = not distances_m or distances_m[nearest] >= self._separation_m
        if is_new and len(self._first_m) < MAX_GROUPS:
            self._first_m.append(position_m)
            return len(self._first_m) - 1
        return nearest


class Agreement:
    """Running sums over frames at the points of a focal surface.

    Only frames of different groups are compared: cameras close together see crowns alike on any surface.
    """

    def __init__(self, points: int, channels: int, groups: int = MAX_GROUPS) -> None:
        self._sums = np.zeros((groups, points, channels), dtype=np.float32)
        self._squares = np.zeros(channels)
        self._coverage = np.zeros((groups, points), dtype=np.float32)
        self._used = 0

    def add(self, samples: NDArray[np.float32], group: int) -> None:
        """Add what one frame shows at the points, shape (points, channels); NaN where it does not cover a point."""
        covered = np.isfinite(samples).all(axis=1)
        known = samples[covered]
        self._sums[group, covered] += known
        self._squares += np.sum(known.astype(np.float64) ** 2, axis=0)
        self._coverage[group] += covered
        self._used = max(self._used, group + 1)

    def value(self) -> float:
        """Return the mean correlation of all pairs of frames: 1 when all are equal, about 0 by chance.

        Channels count alike, whatever their units are; 0 where no two frames overlap or nothing varies.
        """
        pairs = self._pairs()
        varies = self._squares > 0.0
        if pairs == 0.0 or not varies.any():
            return 0.0
        products = _across_groups(self._sums[: self._used])[varies]
        variances = self._squares[varies] / self._coverage.sum(dtype=np.float64)
        return float(np.mean(products / pairs / variances))

    def scatter(self, points_per_patch: float) -> float:
        """Return the standard deviation of :meth:`value` for frames that have nothing in common.

        Args:
            points_per_patch: number of points that vary together, at least 1.
        """
        pairs = self._pairs()
        return math.sqrt(2.0 * max(points_per_patch, 1.0) / pairs) if pairs > 0.0 else math.inf

    def _pairs(self) -> float:
        """Ordered pairs of frames of different groups, summed over the points."""
        return float(_across_groups(self._coverage[: self._used, :, np.newaxis])[0])


def _across_groups(sums: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the products of all pairs of groups, summed over the points: shape (channels,)."""
    total = sums.sum(axis=0, dtype=np.float64)
    return np.asarray(np.sum(total**2, axis=0) - np.sum(sums.astype(np.float64) ** 2, axis=(0, 1)))


def _band_pass(channel: Pixels, size: tuple[int, int]) -> NDArray[np.float32]:
    plane = channel.astype(np.float32)
    unknown = ~np.isfinite(plane)
    known = plane[~unknown]
    # Without the mean, what does not vary is exactly 0, and 16-bit values keep their digits.
    plane -= known.mean(dtype=np.float64) if known.size else 0.0
    plane[unknown] = 0.0
    reduced = cv2.resize(plane, size, interpolation=cv2.INTER_AREA)
    fine, coarse = (cv2.GaussianBlur(reduced, (0, 0), sigma) for sigma in (FINE_SIGMA_PX, COARSE_SIGMA_PX))
    filtered = np.asarray(fine - coarse, dtype=np.float32)
    if unknown.any():
        filtered[cv2.resize(unknown.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.0] = np.nan
    return filtered
