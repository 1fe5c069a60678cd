"""Search for the height, and the tilt if wanted, of the focal plane that a region is in focus on.

The texture of frames is in focus on whatever there is most of, which may be crowns. Where the spots that stand out of
single frames tell the ground from crowns, they decide.

Heights are z coordinates of the world of the poses, whichever way its z axis points.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.focus.fixed_pattern import without_pattern
from aos_gcs.imaging.focus.geometry import COMMON_SIGMA_M, MAX_SLOPE, FocusGeometry, focus_geometry
from aos_gcs.imaging.focus.ground import ground_layer, is_among_crowns, is_seen_through
from aos_gcs.imaging.focus.measure import (
    CORRELATION_AREA_PX,
    Agreement,
    CameraGroups,
    FocusSignal,
    focus_signal,
)
from aos_gcs.imaging.focus.region import FocusRegion
from aos_gcs.imaging.focus.spots import Spots, find_spots
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.terrain import Terrain

FINEST_REDUCTION = 2
"""Pixels per side of the blocks that are averaged first: what is finer seldom survives the errors of poses."""

MAX_SCAN_HEIGHTS = 96
"""Longer ranges are scanned with coarser structure, and refined in more rounds."""

MAX_CANDIDATES = 3
"""Peaks of the scan that are looked at more closely."""

CHANCE_SIGNIFICANCE, SURE_SIGNIFICANCE = 4.0, 12.0
"""Prominences of a peak, in standard deviations of chance, at which confidence begins and is complete.

The best of some dozens of heights reaches 3 by chance.
"""

MIN_CONFIDENCE = 0.2

SURE_SPOTS = 120.0
"""Significance of a layer of spots at which confidence in it is complete."""

SAME_SIGMAS = 3.0
"""Standard deviations within which the texture and a layer of spots mean the same height."""

SPOTS_STEP_M, MAX_SPOTS_HEIGHTS = 0.5, 240
SPOTS_MARGIN_M = 4.0
"""Range to each side in which spots are looked for as well, so that what lies there explains their rays."""

MIN_TILT_GAIN = 3.0
"""Standard deviations of chance by which a tilt must improve the agreement to be taken."""


@dataclass(frozen=True, slots=True)
class FocusResult:
    """Focal plane of a region, or the reason why none was found."""

    plane: Plane
    """The best guess where ``found`` is False; horizontal unless a tilt was looked for."""
    height_m: float
    """z of the plane at the region's centre."""
    confidence: float
    """0 to 1: how far the peak, or the layer of spots, stands out from chance; less for a rival peak nearly as high."""
    sigma_m: float
    """Standard deviation of the height, errors of the poses included; infinite without a peak."""
    agreement: float
    """Mean correlation of all pairs of frames on the plane."""
    found: bool
    reason: str
    """Reason why nothing was found; empty otherwise."""


@dataclass(frozen=True, slots=True, eq=False)
class FocusCurve:
    """The agreement on a series of planes."""

    values: NDArray[np.float64]
    scatter: float
    """Standard deviation of the values by chance."""


@dataclass(frozen=True, slots=True)
class _Peak:
    height_m: float
    prominence: float
    half_width_m: float
    at_limit: bool


def find_focus(
    frames: Iterable[Frame],
    region: FocusRegion,
    low_m: float,
    high_m: float,
    *,
    signal: FocusSignal = FocusSignal.TEXTURE,
    tilt: bool = False,
) -> FocusResult:
    """Find the focal plane that a region is in focus on.

    The whole range is scanned before the best peaks are refined: canopy and ground make the curve multimodal. A height
    among crowns is not found; the layer of spots below them is.

    Args:
        frames: at least two, all with the same bands. They are gone through several times, one after the other.
        region: points to compare.
        low_m: smallest z of the range.
        high_m: greatest z; the cameras must be outside of the range.
        signal: property of the frames that must agree.
        tilt: whether to look for the slopes of the plane, too.

    Raises:
        ImagingError: if the range is not one, or there are fewer than two frames.
    """
    if not (math.isfinite(low_m) and math.isfinite(high_m) and low_m < high_m):
        raise ImagingError(f"The range of heights must be finite and ascending, got {low_m:g} to {high_m:g} m.")
    geometry = focus_geometry(frames, region, (low_m + high_m) / 2)
    if signal is FocusSignal.TEXTURE:
        frames = without_pattern(frames, geometry.separation_m)
    search = _Search(frames, region, signal, geometry)
    reduction = FINEST_REDUCTION
    while (high_m - low_m) / search.geometry.step_m(reduction) > MAX_SCAN_HEIGHTS:
        reduction *= 2
    # Cameras close together blur the peak over the range: some heights are needed to see that there is none.
    step_m = min(search.geometry.step_m(reduction), (high_m - low_m) / 8)
    heights_m = np.linspace(low_m, high_m, math.ceil((high_m - low_m) / step_m) + 1)
    result = _by_agreement(search, heights_m, step_m, reduction)
    if signal is FocusSignal.TEXTURE:
        result = _judged_by_spots(search, result, low_m, high_m)
    return search.tilted(result) if tilt and result.found else result


def _by_agreement(search: _Search, heights_m: NDArray[np.float64], step_m: float, reduction: int) -> FocusResult:
    """Return the height on which the frames agree best, among evenly spaced ones and between them."""
    scan = search.curve([search.plane(height_m) for height_m in heights_m], reduction)
    peaks = _peaks(heights_m, scan)
    inner = [peak for peak in peaks if not peak.at_limit]
    if not inner:
        height_m = peaks[0].height_m if peaks else float(np.mean(heights_m))
        reason = "the agreement is best at the limit of the range" if peaks else "no height is better than another"
        return FocusResult(search.plane(height_m), height_m, 0.0, math.inf, float(scan.values.max()), False, reason)
    # A rise towards the limit is a rival, but no candidate.
    height_m, agreement = search.refine([peak.height_m for peak in inner[:MAX_CANDIDATES]], step_m, reduction)
    return _result(search, height_m, agreement, scan, peaks)


def _judged_by_spots(search: _Search, result: FocusResult, low_m: float, high_m: float) -> FocusResult:
    """Return the ground where spots show it, nothing where they show crowns, and the result otherwise."""
    kinds = _spots(search, low_m, high_m)
    centre_m = search.region.centre_m((low_m + high_m) / 2)[:2]
    layers = (ground_layer(spots, centre_m) for spots in kinds)
    ground = next((layer for layer in layers if layer is not None and low_m <= layer.height_m <= high_m), None)
    if ground is not None:
        # What both have in common counts once.
        same_m = SAME_SIGMAS * math.sqrt(ground.sigma_m**2 + result.sigma_m**2 - COMMON_SIGMA_M**2)
        if result.found and abs(result.height_m - ground.height_m) <= same_m:
            return result
        plane = search.plane(ground.height_m)
        confidence = min(ground.significance / SURE_SPOTS, 1.0)
        agreement = float(search.curve([plane], FINEST_REDUCTION).values[0])
        return FocusResult(plane, ground.height_m, confidence, ground.sigma_m, agreement, True, "")
    if not result.found:
        return result
    if any(is_among_crowns(spots, result.height_m) for spots in kinds):
        reason = f"what stands out at {result.height_m:.1f} m are crowns, and no ground stands out below them"
    elif any(is_seen_through(spots, result.height_m, centre_m) for spots in kinds):
        reason = f"objects are visible far below {result.height_m:.1f} m, but too few of them to locate the ground"
    else:
        return result
    return replace(result, confidence=0.0, found=False, reason=reason)


def _spots(search: _Search, low_m: float, high_m: float) -> list[Spots]:
    """Return the spots in and about the range of heights, within the rectangle about the region."""
    edges_m = np.vstack([search.region.points_m(Plane(height_m)) for height_m in (low_m, high_m)])[:, :2]
    (left_m, near_m), (right_m, far_m) = np.nanmin(edges_m, axis=0), np.nanmax(edges_m, axis=0)
    low_m, high_m = low_m - SPOTS_MARGIN_M, high_m + SPOTS_MARGIN_M
    count = min(math.ceil((high_m - low_m) / SPOTS_STEP_M), MAX_SPOTS_HEIGHTS)
    bounds_m = (float(left_m), float(near_m), float(right_m), float(far_m))
    heights_m = np.linspace(low_m, high_m, count + 1)
    return find_spots(search.frames, bounds_m, heights_m, search.geometry.sampling_m)


def focus_curve(
    frames: Iterable[Frame],
    region: FocusRegion,
    surfaces: Sequence[Plane | Terrain],
    *,
    signal: FocusSignal = FocusSignal.TEXTURE,
    reduction: int = 1,
    separation_m: float = 0.0,
) -> FocusCurve:
    """Return the agreement of frames on some surfaces, in one pass through the frames.

    Args:
        frames: at least two, all with the same bands.
        region: points to compare.
        surfaces: at least one.
        signal: property of the frames to compare.
        reduction: edge of the blocks of pixels that are averaged first.
        separation_m: distance of cameras below which their frames are not compared.

    Raises:
        ImagingError: if there are fewer than two frames.
    """
    lattices = [region.points_m(surface) for surface in surfaces]
    groups = CameraGroups(separation_m)
    sums: list[Agreement] = []
    patches = []
    for frame in frames:
        image = focus_signal(frame.image, signal, reduction)
        sums = sums or [Agreement(len(points), image.shape[2]) for points in lattices]
        group = groups.add(frame.pose.position_enu_m)
        for total, points in zip(sums, lattices, strict=True):
            pixels = project_points(points, frame.camera, frame.pose)
            total.add(_sample(image, pixels, reduction), group)
        patches.append(CORRELATION_AREA_PX * reduction**2 / _pixels_per_point(pixels))
    if len(patches) < 2:
        raise ImagingError(f"Focusing needs at least two frames, got {len(patches)}.")
    scatter = float(np.median([total.scatter(float(np.nanmedian(patches))) for total in sums]))
    return FocusCurve(np.array([total.value() for total in sums]), scatter)


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    frames: Iterable[Frame]
    region: FocusRegion
    signal: FocusSignal
    geometry: FocusGeometry

    def plane(self, height_m: float, slopes: tuple[float, float] = (0.0, 0.0)) -> Plane:
        """Return the plane that has this height at the region's centre."""
        return Plane.through(self.region.centre_m(height_m), *slopes) if any(slopes) else Plane(height_m)

    def curve(self, planes: Sequence[Plane], reduction: int) -> FocusCurve:
        return focus_curve(
            self.frames,
            self.region,
            planes,
            signal=self.signal,
            reduction=reduction,
            separation_m=self.geometry.separation_m,
        )

    def refine(self, candidates_m: Sequence[float], step_m: float, reduction: int) -> tuple[float, float]:
        """Return the best height and its agreement, looked for about each candidate with ever finer structure."""
        while True:
            reduction = max(reduction // 2, FINEST_REDUCTION)
            step_m /= 2
            offsets_m = step_m * np.arange(-3, 4)
            heights_m = np.add.outer(candidates_m, offsets_m)
            planes = [self.plane(float(height_m)) for height_m in heights_m.ravel()]
            values = self.curve(planes, reduction).values.reshape(heights_m.shape)
            best = int(values.max(axis=1).argmax())
            if reduction == FINEST_REDUCTION:
                height_m = heights_m[best, 3] + step_m * (_vertex(values[best]) - 3)
                return float(height_m), float(values[best].max())
            candidates_m = heights_m[np.arange(len(values)), values.argmax(axis=1)].tolist()

    def tilted(self, level: FocusResult) -> FocusResult:
        """Return the result with the slopes that improve the agreement beyond chance, or as it was."""
        centre_m = self.region.centre_m(level.height_m)
        offsets_m = np.abs(self.region.points_m(level.plane) - centre_m)[:, :2]
        reach_m = float(np.nanmean(offsets_m.max(axis=1)))
        estimate = np.array([level.height_m, 0.0, 0.0])
        step_m = self.geometry.step_m(FINEST_REDUCTION)
        for fineness in (1.0, 0.5):
            steps = fineness * np.array([step_m / 2, *[step_m / reach_m] * 2])
            slope_count = math.ceil(MAX_SLOPE / steps[1]) if fineness == 1.0 else 3
            for axis in (1, 2, 0, 1, 2, 0):
                estimate, curve = self._best_along(estimate, axis, steps[axis], slope_count if axis else 3)
        agreement = float(curve.values.max())
        if agreement < level.agreement + MIN_TILT_GAIN * curve.scatter:
            return level
        height_m, slopes = float(estimate[0]), (float(estimate[1]), float(estimate[2]))
        return replace(level, plane=self.plane(height_m, slopes), height_m=height_m, agreement=agreement)

    def _best_along(
        self, estimate: NDArray[np.float64], axis: int, step: float, count: int
    ) -> tuple[NDArray[np.float64], FocusCurve]:
        """Vary one of height, slope along x, slope along y."""
        tried = np.tile(estimate, (2 * count + 1, 1))
        tried[:, axis] += step * np.arange(-count, count + 1)
        curve = self.curve([self.plane(float(h), (float(x), float(y))) for h, x, y in tried], FINEST_REDUCTION)
        best = estimate.copy()
        best[axis] += step * (_vertex(curve.values) - count)
        return best, curve


def _sample(image: NDArray[np.float32], pixels: NDArray[np.float64], reduction: int) -> NDArray[np.float32]:
    """Return a reduced image at pixels of the full one, shape (n, C); NaN outside and where they are NaN."""
    reduced = (np.nan_to_num(pixels, nan=-1e6) + 0.5) / reduction - 0.5
    # Beyond one pixel outside all coordinates are alike, and OpenCV's own range is limited.
    u, v = np.clip(reduced, -2.0, [image.shape[1] + 1.0, image.shape[0] + 1.0]).astype(np.float32).T
    samples = cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=[math.nan] * 4)
    return np.asarray(samples, dtype=np.float32).reshape(len(pixels), image.shape[2])


def _pixels_per_point(pixels: NDArray[np.float64]) -> float:
    """Return how many pixels of a frame there are to a point of the lattice; NaN if the frame sees none."""
    known = pixels[np.isfinite(pixels).all(axis=1)]
    return float(np.ptp(known, axis=0).prod()) / len(known) if len(known) > 1 else math.nan


def _peaks(heights_m: NDArray[np.float64], curve: FocusCurve) -> list[_Peak]:
    """Return the peaks, the most prominent one first; the ends of the range count as peaks where the curve rises."""
    # Its import takes a second: only the processes that focus pay for it, when they do.
    from scipy.signal import find_peaks, peak_widths  # noqa: PLC0415

    padded = np.concatenate(([curve.values.min()], curve.values, [curve.values.min()]))
    indices, found = find_peaks(padded, prominence=(None, None))
    prominence_data = (found["prominences"], found["left_bases"], found["right_bases"])
    widths = peak_widths(padded, indices, 0.5, prominence_data)[0] if indices.size else indices
    half_widths_m = widths / 2.0 * float(heights_m[1] - heights_m[0])
    peaks = [
        _Peak(float(heights_m[index - 1]), float(prominence), float(half_width_m), index in (1, len(heights_m)))
        for index, prominence, half_width_m in zip(indices, found["prominences"], half_widths_m, strict=True)
    ]
    return sorted(peaks, key=lambda peak: -peak.prominence)


def _result(
    search: _Search, height_m: float, agreement: float, scan: FocusCurve, peaks: Sequence[_Peak]
) -> FocusResult:
    """Judge the refined height by the peak that it comes from, and by the others."""
    chosen = min((peak for peak in peaks if not peak.at_limit), key=lambda peak: abs(peak.height_m - height_m))
    rival = max((peak.prominence for peak in peaks if peak is not chosen), default=0.0)
    distinctness = 1.0 - min(rival / chosen.prominence, 1.0)
    significance = max(min(chosen.prominence, agreement) / scan.scatter, 0.0)
    sureness = (significance - CHANCE_SIGNIFICANCE) / (SURE_SIGNIFICANCE - CHANCE_SIGNIFICANCE)
    sureness = min(max(sureness, 0.0), 1.0)
    found = sureness * distinctness >= MIN_CONFIDENCE
    reason = "another height is about as good" if distinctness < sureness else "the agreement may be chance"
    chance_m = chosen.half_width_m / math.sqrt(significance) if significance > 0.0 else math.inf
    return FocusResult(
        plane=search.plane(height_m),
        height_m=height_m,
        confidence=sureness * distinctness,
        sigma_m=math.hypot(chance_m, COMMON_SIGMA_M),
        agreement=agreement,
        found=found,
        reason="" if found else reason,
    )


def _vertex(values: NDArray[np.float64]) -> float:
    """Return where the parabola through the greatest value and its neighbours peaks, in indices."""
    best = int(values.argmax())
    if not 0 < best < len(values) - 1:
        return float(best)
    before, at, after = values[best - 1 : best + 2]
    curvature = before - 2.0 * at + after
    return float(best) if curvature >= 0.0 else best + float(0.5 * (before - after) / curvature)
