"""Points of the ground that several images show: features that look alike, and fit one geometry pair by pair.

Sources: Lowe, *Distinctive image features from scale-invariant keypoints*, IJCV 60(2), 2004 (features and the test of
the second best); Arandjelović and Zisserman, *Three things everyone should know to improve object retrieval*, CVPR 2012
(square roots of descriptors).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Pixels

MAX_FEATURES = 800
"""Features of an image."""
MAX_TRACKS = 2000
"""Points that are used, those of the most images first."""
MAX_EDGE_PX = 1600
"""Larger images are reduced for the search: their finest structure is noise."""
RATIO = 0.8
"""Distance of the best match over that of the second best: more alike are not told apart."""
EPIPOLAR_PX = 2.0
MIN_MATCHES = 12
"""Matches of a pair that fit one geometry; fewer may do so by chance."""
MIN_PARALLAX_RAD = np.radians(1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """Features of one image."""

    pixels: NDArray[np.float64]
    """Places (u, v), shape (k, 2)."""
    descriptors: NDArray[np.float32]
    """Unit vectors, shape (k, 128)."""


@dataclass(frozen=True, slots=True, eq=False)
class FeatureTracks:
    """Points and where images show them; arrays with one row per observation."""

    image: NDArray[np.intp]
    """Shape (k,)."""
    point: NDArray[np.intp]
    pixels: NDArray[np.float64]
    """Shape (k, 2)."""

    @property
    def count(self) -> int:
        """Number of points."""
        return int(self.point.max()) + 1 if len(self.point) else 0

    def chosen(self, keep: NDArray[np.bool_]) -> FeatureTracks:
        """Return the tracks of some points, shape (count,), numbered anew."""
        seen = keep[self.point]
        number = np.cumsum(keep) - 1
        return FeatureTracks(self.image[seen], number[self.point[seen]], self.pixels[seen])

    def in_images(self, images: NDArray[np.intp]) -> FeatureTracks:
        """Return what at least two of some images show, both images and points numbered anew, the latter in order."""
        seen = np.isin(self.image, images)
        counts = np.bincount(self.point[seen], minlength=self.count)
        seen &= counts[self.point] > 1
        number = np.cumsum(counts > 1) - 1
        return FeatureTracks(np.searchsorted(images, self.image[seen]), number[self.point[seen]], self.pixels[seen])


def find_features(image: Pixels) -> Features:
    """Return the features of an image, shape (H, W, C), of any depth."""
    grey = image.astype(np.float32).mean(axis=2)
    low, high = np.percentile(grey, (1.0, 99.0))
    stretched = np.clip((grey - low) * (255.0 / max(float(high - low), 1e-6)), 0.0, 255.0).astype(np.uint8)
    scale = min(1.0, MAX_EDGE_PX / max(stretched.shape))
    if scale < 1.0:
        stretched = np.asarray(cv2.resize(stretched, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    # Without the precise enlargement, places are off by a quarter of a pixel.
    sift = cv2.SIFT.create(MAX_FEATURES, contrastThreshold=0.02, enable_precise_upscale=True)
    found, descriptors = sift.detectAndCompute(stretched, None)
    if descriptors is None:
        return Features(np.empty((0, 2)), np.empty((0, 128), dtype=np.float32))
    roots = np.sqrt(descriptors / np.maximum(np.abs(descriptors).sum(axis=1, keepdims=True), 1e-6))
    height, width = stretched.shape
    ratio = np.array([grey.shape[1] / width, grey.shape[0] / height])
    places = (np.array([feature.pt for feature in found]) + 0.5) * ratio - 0.5
    return Features(places, roots.astype(np.float32))


def match(first: Features, second: Features, camera: CameraModel) -> NDArray[np.intp]:
    """Return pairs of features, shape (k, 2), that are each other's best match and fit one epipolar geometry."""
    none = np.empty((0, 2), dtype=np.intp)
    if min(len(first.pixels), len(second.pixels)) < MIN_MATCHES:
        return none
    likeness = first.descriptors @ second.descriptors.T
    best = likeness.argmax(axis=1)
    rows = np.arange(len(best))
    mutual = likeness.argmax(axis=0)[best] == rows
    top = likeness[rows, best]
    likeness[rows, best] = -1.0
    # Unit vectors: the squared distance is 2 - 2 likeness.
    is_distinct = 1.0 - top < RATIO**2 * (1.0 - likeness.max(axis=1))
    pairs = np.column_stack((rows, best))[is_distinct & mutual]
    if len(pairs) < MIN_MATCHES:
        return none
    ideal = [camera.from_pixels(side.pixels[pairs[:, k]]) * camera.fx_px for k, side in enumerate((first, second))]
    usable = np.isfinite(ideal[0]).all(axis=1) & np.isfinite(ideal[1]).all(axis=1)
    pairs, ideal = pairs[usable], [points[usable] for points in ideal]
    if len(pairs) < MIN_MATCHES:
        return none
    _, fits = cv2.findFundamentalMat(ideal[0], ideal[1], cv2.FM_RANSAC, EPIPOLAR_PX, 0.999, 2000)
    kept = none if fits is None else np.asarray(pairs[np.ravel(fits) > 0], dtype=np.intp)
    return kept if len(kept) >= MIN_MATCHES else none


def make_tracks(features: Sequence[Features], matches: Iterable[tuple[int, int, NDArray[np.intp]]]) -> FeatureTracks:
    """Join pairs of features, given with the indices of their images, to points.

    Points that one image shows twice are left out, as some of their matches must be wrong.
    """
    starts = np.concatenate(([0], np.cumsum([len(one.pixels) for one in features])))
    parents = np.arange(starts[-1])

    def root(node: int) -> int:
        while parents[node] != node:
            parents[node] = parents[parents[node]]
            node = int(parents[node])
        return node

    for first, second, pairs in matches:
        for a, b in pairs:
            parents[root(int(starts[first] + a))] = root(int(starts[second] + b))
    roots = np.array([root(node) for node in range(len(parents))], dtype=np.intp)
    image = np.repeat(np.arange(len(features)), np.diff(starts))
    members: dict[int, list[int]] = {}
    for node, top in enumerate(roots.tolist()):
        members.setdefault(top, []).append(node)
    tracks = [nodes for nodes in members.values() if len(nodes) > 1 and len(set(image[nodes].tolist())) == len(nodes)]
    tracks = sorted(tracks, key=len, reverse=True)[:MAX_TRACKS]
    nodes = np.array([node for track in tracks for node in track], dtype=np.intp)
    point = np.repeat(np.arange(len(tracks)), [len(track) for track in tracks])
    pixels = np.concatenate([one.pixels for one in features]) if features else np.empty((0, 2))
    return FeatureTracks(image[nodes], point.astype(np.intp), pixels[nodes])


def triangulate(
    tracks: FeatureTracks, camera: CameraModel, poses: Sequence[Pose]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the points nearest to their rays, shape (m, 3), and which of them lie in front of their cameras.

    Points with less than :data:`MIN_PARALLAX_RAD` are not usable either.
    """
    R = np.array([pose.R_cam2enu for pose in poses])[tracks.image]
    centres_m = np.array([pose.position_enu_m for pose in poses])[tracks.image]
    rays_cam = np.column_stack((camera.from_pixels(tracks.pixels), np.ones(len(tracks.pixels))))
    rays = np.einsum("kij,kj->ki", R, rays_cam / np.linalg.norm(rays_cam, axis=1, keepdims=True))
    is_seen = np.isfinite(rays).all(axis=1)
    rays = np.where(is_seen[:, np.newaxis], rays, 0.0)
    across = np.eye(3) - rays[:, :, np.newaxis] * rays[:, np.newaxis, :]
    N, right, mean_ray = np.zeros((tracks.count, 3, 3)), np.zeros((tracks.count, 3)), np.zeros((tracks.count, 3))
    np.add.at(N, tracks.point, across)
    np.add.at(right, tracks.point, np.einsum("kij,kj->ki", across, centres_m))
    np.add.at(mean_ray, tracks.point, rays)
    mean_ray /= np.maximum(np.linalg.norm(mean_ray, axis=1, keepdims=True), 1e-9)
    spread = np.zeros(tracks.count)
    off_axis = np.arccos(np.clip(np.einsum("ki,ki->k", rays, mean_ray[tracks.point]), -1.0, 1.0))
    np.maximum.at(spread, tracks.point, np.where(is_seen, off_axis, np.inf))
    usable = (2.0 * spread > MIN_PARALLAX_RAD) & np.isfinite(spread)
    points_m = np.full((tracks.count, 3), np.nan)
    points_m[usable] = np.linalg.solve(N[usable], right[usable][:, :, np.newaxis])[:, :, 0]
    depth_m = np.einsum("ki,ki->k", points_m[tracks.point] - centres_m, rays)
    behind = np.zeros(tracks.count, dtype=np.bool_)
    np.logical_or.at(behind, tracks.point, ~(depth_m > 0.0))
    return points_m, usable & ~behind
