"""Spots that stand out of single frames, and where in space their rays meet.

A stone, a person or a branch that is brighter than its surroundings is seen by several frames where it is. How many
rays meet by chance follows from the number of spots per frame. Each ray belongs to the most significant meeting only:
a crown's rays also come close to each other on planes far below it.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import pixel_rays, project_points
from aos_gcs.imaging.model import Frame, Pixels
from aos_gcs.imaging.undistort import seen_pixels

SPOT_SAMPLING_M = 0.07
"""Ground sampling distance at which the sizes in pixels below suit persons, stones and branches.

Finer frames are reduced to about it: else their spots would be single leaves.
"""

SPOTS_PER_FRAME = 60
SPOT_SIGMA_PX, SURROUNDINGS = 1.5, 4.0
"""Size of a spot, and that of its surroundings in multiples of it."""

CONTRAST_WINDOW_PX = 55
"""Edge of the window of the local contrast."""

FLAT_SHARE = 0.3
"""Share of the whole frame's contrast that is added to the local one, so that noise in flat parts is no spot."""

MIN_CONTRAST = 2.5
"""Standard deviations of the local contrast from which a spot is one."""

RADIUS_M = 0.35
"""Distance within which rays meet: errors of good poses, and the size of things."""

REACH = 1.3
"""Multiple of the radius within which rays belong to a meeting once its place is known."""

MIN_FRAMES = 4
MIN_SIGNIFICANCE = 5.0
"""-log10 of the probability by chance from which a meeting counts."""

MAX_SIGNIFICANCE = 100.0
MIN_VIEWS = 8
"""Frames that must see a place."""

MAX_SPOTS = 100
MAX_SHIFT_M = 3.0
"""Distance from the plane on which a meeting was found to where it is."""

MIN_RAY_SIGMA_M = 0.1
"""Smallest standard deviation of rays about their meeting."""

ROUNDS = 5
SEPARATION_PX = 9
FAR_M = 1e9


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """Places where rays of spots meet; arrays of n."""

    points_m: NDArray[np.float64]
    """Shape (n, 3)."""
    significances: NDArray[np.float64]
    """-log10 of the probability that as many rays meet by chance."""
    sigmas_m: NDArray[np.float64]
    """Standard deviations of the heights, by how closely the rays meet."""
    up: float
    """1 where z points up, to the cameras, and -1 where it points down."""


@dataclass(frozen=True, slots=True)
class _View:
    """Camera of a frame, without its image."""

    camera: CameraModel
    pose: Pose

    def sees(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        return seen_pixels(project_points(points_m, self.camera, self.pose), self.camera)

    def share_of_disc(self, height_m: float) -> float:
        """Return which share of the image a disc of the radius takes on a level plane."""
        depth_m = abs(height_m - float(self.pose.position_enu_m[2]))
        pixels = math.pi * RADIUS_M**2 * self.camera.fx_px * self.camera.fy_px / max(depth_m, RADIUS_M) ** 2
        return pixels / (self.camera.width_px * self.camera.height_px)


@dataclass(frozen=True, slots=True, eq=False)
class _Rays:
    """Rays of all spots; arrays of n."""

    origins_m: NDArray[np.float64]
    directions: NDArray[np.float64]
    """Unit vectors."""
    frames: NDArray[np.intp]

    def at(self, height_m: float) -> NDArray[np.float64]:
        """Return where the rays meet a level plane, shape (n, 2); far away if nowhere."""
        rise = self.directions[:, 2]
        steps_m = (height_m - self.origins_m[:, 2]) / np.where(rise == 0.0, np.nan, rise)
        places_m = (self.origins_m + steps_m[:, np.newaxis] * self.directions)[:, :2]
        # Far from each other, too: the tree of places is slow where many are at one.
        nowhere_m = FAR_M * np.arange(1, len(places_m) + 1)[:, np.newaxis]
        return np.where((steps_m > 0.0)[:, np.newaxis], places_m, nowhere_m)

    def distances_m(self, point_m: NDArray[np.float64]) -> NDArray[np.float64]:
        gaps_m = point_m - self.origins_m
        along_m = np.sum(gaps_m * self.directions, axis=1, keepdims=True)
        return np.asarray(np.linalg.norm(gaps_m - along_m * self.directions, axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class _Candidates:
    """Places on a level plane where rays of several frames come near that of one."""

    height_m: float
    near: list[NDArray[np.intp]]
    """Indices of the rays near each of them."""
    places_m: NDArray[np.float64]
    significances: NDArray[np.float64]
    by_count: NDArray[np.float64]
    """Significance by the number of frames, shape (n, frames + 1)."""


def spot_planes(frame: Frame) -> list[Pixels]:
    """Return what spots are looked for in, each of shape (H, W): the thermal band, then the mean of the others."""
    is_thermal = np.array([band == "thermal" for band in frame.bands])
    return [frame.image[:, :, chosen].mean(axis=2) for chosen in (is_thermal, ~is_thermal) if chosen.any()]


def detect_spots(image: Pixels, reduction: int = 1) -> NDArray[np.float64]:
    """Return the brightest spots of an image.

    Args:
        image: shape (H, W), any real type; NaN where it is not known.
        reduction: edge of the square blocks of pixels that are averaged first.

    Returns:
        Pixels of the whole image, shape (n, 2).
    """
    plane = image.astype(np.float32)
    known = np.isfinite(plane)
    if not known.any():
        return np.empty((0, 2))
    plane = np.where(known, plane - plane[known].mean(dtype=np.float64), 0.0).astype(np.float32)
    if reduction > 1:
        size = (math.ceil(plane.shape[1] / reduction), math.ceil(plane.shape[0] / reduction))
        plane = np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), dtype=np.float32)
        known = cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_AREA) == 1.0
    fine, coarse = (cv2.GaussianBlur(plane, (0, 0), sigma) for sigma in (SPOT_SIGMA_PX, SPOT_SIGMA_PX * SURROUNDINGS))
    excess = fine - coarse
    # A running sum may round to less than nothing where the image is flat.
    variance = np.maximum(cv2.blur(excess**2, (CONTRAST_WINDOW_PX, CONTRAST_WINDOW_PX)), 0.0)
    deviation = np.sqrt(variance) + FLAT_SHARE * excess.std()
    contrast = excess / np.maximum(deviation, np.finfo(np.float32).tiny)
    highest = cv2.dilate(contrast, np.ones((SEPARATION_PX, SEPARATION_PX)))
    rows, columns = np.nonzero((contrast == highest) & (contrast > MIN_CONTRAST) & known)
    best = np.argsort(-contrast[rows, columns], kind="stable")[:SPOTS_PER_FRAME]
    places = np.column_stack((columns[best], rows[best])).astype(np.float64)
    scale = np.array(image.shape[::-1]) / plane.shape[::-1]
    return np.asarray((places + 0.5) * scale - 0.5)


def find_spots(
    frames: Iterable[Frame],
    bounds_m: tuple[float, float, float, float],
    heights_m: NDArray[np.float64],
    sampling_m: float = SPOT_SAMPLING_M,
) -> list[Spots]:
    """Return where rays of spots meet: those of the thermal band, then those of the others, where there are any.

    Args:
        frames: gone through once; all with the same bands.
        bounds_m: smallest x and y, greatest x and y of the places.
        heights_m: level planes near which places are looked for; not further apart than rays that meet stay together.
        sampling_m: ground sampling distance of the frames.
    """
    reduction = max(round(SPOT_SAMPLING_M / sampling_m), 1)
    views: list[_View] = []
    pixels: list[list[NDArray[np.float64]]] = []
    for frame in frames:
        views.append(_View(frame.camera, frame.pose))
        pixels.append([detect_spots(plane, reduction) for plane in spot_planes(frame)])
    return [_meetings(views, list(of_plane), bounds_m, heights_m) for of_plane in zip(*pixels, strict=True)]


def _meetings(
    views: list[_View],
    pixels: list[NDArray[np.float64]],
    bounds_m: tuple[float, float, float, float],
    heights_m: NDArray[np.float64],
) -> Spots:
    """Return the places where rays meet, the most significant first; ``pixels`` has the spots of each view."""
    rays = _rays(views, pixels)
    layers = [layer for height_m in heights_m if (layer := _candidates(views, rays, bounds_m, float(height_m)))]
    heap = [
        (-float(significance), index, place)
        for index, layer in enumerate(layers)
        for place, significance in enumerate(layer.significances)
    ]
    heapq.heapify(heap)
    is_free = np.ones(len(rays.frames), dtype=bool)
    points_m: list[NDArray[np.float64]] = []
    significances: list[float] = []
    sigmas_m: list[float] = []
    while heap and len(points_m) < MAX_SPOTS:
        stated, index, place = heapq.heappop(heap)
        layer = layers[index]
        near = layer.near[place][is_free[layer.near[place]]]
        count = len(np.unique(rays.frames[near]))
        significance = float(layer.by_count[place, count])
        if count < MIN_FRAMES or significance < MIN_SIGNIFICANCE:
            continue
        if significance < -stated:
            heapq.heappush(heap, (-significance, index, place))
            continue
        start_m = np.array([*layer.places_m[place], layer.height_m])
        point_m, sigma_m, taken = _meeting_point(rays, is_free, start_m)
        is_free[near] = False
        is_free[taken] = False
        if math.isfinite(sigma_m) and abs(point_m[2] - layer.height_m) <= MAX_SHIFT_M:
            points_m.append(point_m)
            significances.append(significance)
            sigmas_m.append(sigma_m)
    height_m = float(np.mean([view.pose.position_enu_m[2] for view in views]))
    up = 1.0 if height_m > float(np.mean(heights_m)) else -1.0
    return Spots(np.array(points_m).reshape(-1, 3), np.array(significances), np.array(sigmas_m), up)


def _rays(views: list[_View], pixels: list[NDArray[np.float64]]) -> _Rays:
    origins_m, directions, indices = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, dtype=np.intp)]
    for index, (view, spots) in enumerate(zip(views, pixels, strict=True)):
        towards = pixel_rays(spots, view.camera, view.pose)
        directions.append(towards / np.linalg.norm(towards, axis=1, keepdims=True))
        origins_m.append(np.tile(view.pose.position_enu_m, (len(spots), 1)))
        indices.append(np.full(len(spots), index, dtype=np.intp))
    known = np.isfinite(np.vstack(directions)).all(axis=1)
    return _Rays(np.vstack(origins_m)[known], np.vstack(directions)[known], np.concatenate(indices)[known])


def _candidates(
    views: list[_View], rays: _Rays, bounds_m: tuple[float, float, float, float], height_m: float
) -> _Candidates | None:
    """Return the places on a plane where more rays meet than chance explains; None if there are none."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - only the processes that focus pay for the import
    from scipy.stats import binom  # noqa: PLC0415

    places_m = rays.at(height_m)
    inside = np.all((places_m >= bounds_m[:2]) & (places_m <= bounds_m[2:]), axis=1)
    if not inside.any():
        return None
    tree = cKDTree(places_m)
    pairs = tree.query_pairs(RADIUS_M, output_type="ndarray")
    pairs = np.vstack((pairs, pairs[:, ::-1], np.repeat(np.arange(len(places_m)), 2).reshape(-1, 2)))
    distinct = np.unique(pairs[:, 0] * len(views) + rays.frames[pairs[:, 1]])
    counts = np.bincount(distinct // len(views), minlength=len(places_m))
    chosen = np.flatnonzero(inside & (counts >= MIN_FRAMES))
    if not chosen.size:
        return None
    centres_m = np.column_stack((places_m[chosen], np.full(len(chosen), height_m)))
    seen = np.sum([view.sees(centres_m) for view in views], axis=0)
    spots = np.bincount(rays.frames, minlength=len(views))
    chance = float(np.mean([view.share_of_disc(height_m) for view in views] * spots))
    by_count = -binom.logsf(np.arange(len(views) + 1)[np.newaxis] - 1, seen[:, np.newaxis], min(chance, 1.0))
    by_count = np.where(seen[:, np.newaxis] >= MIN_VIEWS, np.minimum(by_count / math.log(10.0), MAX_SIGNIFICANCE), 0.0)
    significances = by_count[np.arange(len(chosen)), counts[chosen]]
    good = significances >= MIN_SIGNIFICANCE
    near = [np.array(rows, dtype=np.intp) for rows in tree.query_ball_point(places_m[chosen[good]], RADIUS_M)]
    return _Candidates(height_m, near, places_m[chosen[good]], significances[good], by_count[good])


def _meeting_point(
    rays: _Rays, is_free: NDArray[np.bool_], point_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, NDArray[np.intp]]:
    """Return the point nearest to the free rays about a point, the deviation of its height, and these rays."""
    sigma_m, taken = math.inf, np.empty(0, dtype=np.intp)
    for _ in range(ROUNDS):
        distances_m = rays.distances_m(point_m)
        taken = np.flatnonzero(is_free & (distances_m < REACH * RADIUS_M))
        if len(taken) < MIN_FRAMES:
            return point_m, math.inf, taken
        along = rays.directions[taken]
        across = np.eye(3) - along[:, :, np.newaxis] * along[:, np.newaxis, :]
        try:
            covariance = np.linalg.inv(across.sum(axis=0))
        except np.linalg.LinAlgError:
            return point_m, math.inf, taken
        point_m = covariance @ np.einsum("nij,nj->i", across, rays.origins_m[taken])
        left_m2 = float(np.sum(rays.distances_m(point_m)[taken] ** 2)) / (2 * len(taken) - 3)
        sigma_m = max(math.sqrt(left_m2), MIN_RAY_SIGMA_M) * math.sqrt(max(float(covariance[2, 2]), 0.0))
    return point_m, sigma_m, taken
