"""Ties between frames: by how much two of them show the same patch of the world at different places.

Every frame is brought to small horizontal rasters (patches), each at a height of its own, and all pairs of frames that
see a patch are cross-correlated there. The measurement takes no view on what the patch shows: leaves, ground, or both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.imaging.focus.measure import FocusSignal, focus_signal
from aos_gcs.imaging.model import Frame

SEARCH_SHARE = 0.35
"""Share of a patch's edge by which the content may be displaced. Beyond, too little of it is common to both."""

MIN_PEAK_SIGMAS = 5.0
"""Smallest prominence of a peak above the rest of the correlation; the best of 500 places reaches 3 to 4 by chance."""


@dataclass(frozen=True, slots=True)
class PatchSize:
    """Sampling of patches."""

    edge_px: int
    resolution_m: float

    @property
    def edge_m(self) -> float:
        """Edge of a patch."""
        return self.edge_px * self.resolution_m


@dataclass(frozen=True, slots=True, eq=False)
class Ties:
    """Displacements between frames; arrays with one row per tie."""

    patch: NDArray[np.intp]
    first: NDArray[np.intp]
    """Index of the frame that the displacement starts from, shape (k,)."""
    second: NDArray[np.intp]
    displacement_m: NDArray[np.float64]
    """Along x and y, from where the first frame shows the patch's content to where the second does, shape (k, 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Structure:
    """A frame reduced to its band-passed structure."""

    image: NDArray[np.float32]
    camera: CameraModel
    H_full2reduced: NDArray[np.float64]

    @classmethod
    def of(cls, frame: Frame, sampling_m: float, resolution_m: float) -> _Structure:
        reduction = max(1, round(resolution_m / sampling_m))
        scale, shift = 1.0 / reduction, 0.5 / reduction - 0.5
        return cls(
            focus_signal(frame.image, FocusSignal.TEXTURE, reduction),
            frame.camera,
            np.array([[scale, 0.0, shift], [0.0, scale, shift], [0.0, 0.0, 1.0]]),
        )

    def on_patch(
        self, pose: Pose, centre_m: NDArray[np.float64], H_patch2plane: NDArray[np.float64], edge_px: int
    ) -> NDArray[np.float32] | None:
        """Return the normalised structure on a patch, shape (C, edge, edge); None unless all of it is in the image."""
        H = self.H_full2reduced @ plane_to_image(self.camera, pose, float(centre_m[2])) @ H_patch2plane
        last = edge_px - 1.0
        u, v, depth = H @ np.array([[0.0, last, last, 0.0], [0.0, 0.0, last, last], [1.0, 1.0, 1.0, 1.0]])
        height, width, channels = self.image.shape
        if (depth <= 0.0).any() or not (
            (u >= 0.0).all()
            and (u <= (width - 1) * depth).all()
            and (v >= 0.0).all()
            and (v <= (height - 1) * depth).all()
        ):
            return None
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        warped = cv2.warpPerspective(self.image, H, (edge_px, edge_px), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        values = np.moveaxis(warped.reshape(edge_px, edge_px, channels), 2, 0)
        values = values - values.mean(axis=(1, 2), keepdims=True)
        deviation = values.std(axis=(1, 2), keepdims=True)
        if not np.isfinite(deviation).all() or not (deviation > 0.0).any():
            return None
        return np.asarray(values / np.where(deviation > 0.0, deviation, np.inf), dtype=np.float32)


def measure_ties(
    frames: Sequence[Frame],
    poses: Sequence[Pose],
    patches_m: NDArray[np.float64],
    pairs: NDArray[np.bool_],
    size: PatchSize,
) -> Ties:
    """Correlate pairs of frames on patches.

    Args:
        frames: without distortion, all with the same bands.
        poses: best estimates of the frames' poses.
        patches_m: centres of the patches, shape (m, 3).
        pairs: frames to compare, shape (n, n); the upper triangle counts.
        size: size of all patches.
    """
    heights_m = np.array([pose.position_enu_m[2] for pose in poses])
    sampling_m = float(np.median(np.abs(heights_m - patches_m[:, 2].mean()))) / frames[0].camera.fx_px
    structures = [_Structure.of(frame, sampling_m, size.resolution_m) for frame in frames]
    found = [_correlate(structures, poses, centre_m, pairs, size) for centre_m in patches_m]
    index = np.concatenate([np.full(len(first), k) for k, (first, _, _) in enumerate(found)] or [np.empty(0)])
    return Ties(
        index.astype(np.intp),
        np.concatenate([first for first, _, _ in found]),
        np.concatenate([second for _, second, _ in found]),
        np.concatenate([displacement_m for _, _, displacement_m in found]),
    )


def _correlate(
    structures: Sequence[_Structure],
    poses: Sequence[Pose],
    centre_m: NDArray[np.float64],
    pairs: NDArray[np.bool_],
    size: PatchSize,
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Return the frames and displacements of the ties on one patch."""
    half_m = size.resolution_m * (size.edge_px - 1) / 2
    r, (x_m, y_m, _) = size.resolution_m, centre_m
    H_patch2plane = np.array([[r, 0.0, x_m - half_m], [0.0, -r, y_m + half_m], [0.0, 0.0, 1.0]])
    views = [
        structure.on_patch(pose, centre_m, H_patch2plane, size.edge_px)
        for structure, pose in zip(structures, poses, strict=True)
    ]
    seen = np.array([index for index, view in enumerate(views) if view is not None], dtype=np.intp)
    first, second = np.nonzero(np.triu(pairs[np.ix_(seen, seen)], 1))
    if not first.size:
        return seen[:0], seen[:0], np.empty((0, 2))
    window = np.hanning(size.edge_px + 2)[1:-1].astype(np.float32)
    spectra = np.fft.rfft2(np.stack([view for view in views if view is not None]) * np.outer(window, window))
    # One spectrum per frame serves all of its pairs.
    cross = np.einsum("pcij,pcij->pij", spectra[first].conj(), spectra[second])
    columns, rows, sure = _peaks(np.asarray(np.fft.irfft2(cross, (size.edge_px, size.edge_px))))
    displacement_m = r * np.column_stack((columns, -rows))
    return seen[first[sure]], seen[second[sure]], displacement_m[sure]


def _peaks(
    correlation: NDArray[np.float32],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return the columns and rows of the peaks about the middle, and which of them are sure; each of shape (k,)."""
    count, edge, _ = correlation.shape
    reach = math.floor(SEARCH_SHARE * edge)
    centred = np.fft.fftshift(correlation, axes=(1, 2))
    low = edge // 2 - reach
    searched = centred[:, low : low + 2 * reach + 1, low : low + 2 * reach + 1]
    row, column = np.unravel_index(searched.reshape(count, -1).argmax(axis=1), searched.shape[1:])
    inner = (row > 0) & (row < 2 * reach) & (column > 0) & (column < 2 * reach)
    each, r, c = np.arange(count), np.clip(row, 1, 2 * reach - 1), np.clip(column, 1, 2 * reach - 1)
    peak = searched[each, r, c]
    sure = inner & (peak > centred.mean(axis=(1, 2)) + MIN_PEAK_SIGMAS * centred.std(axis=(1, 2)))
    rows = r + _vertex(searched[each, r - 1, c], peak, searched[each, r + 1, c]) - reach
    columns = c + _vertex(searched[each, r, c - 1], peak, searched[each, r, c + 1]) - reach
    return columns, rows, sure


def _vertex(before: NDArray[np.float32], at: NDArray[np.float32], after: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return how far from the middle one of three values a parabola through them peaks."""
    curvature = before - 2.0 * at + after
    offset = np.where(curvature < 0.0, 0.5 * (before - after) / np.where(curvature < 0.0, curvature, 1.0), 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5), dtype=np.float64)
