"""Size and warmth of a body by all frames that show it: what does not depend on how warm the day is.

Leaves leave a frame a part of a body only, and errors of poses lay the parts that frames show beside one another.
Within a frame, places and temperatures keep their relation. So each frame's pixels are taken about their own middle,
and only sums over frames are kept, to which those of a later step are added.

A vehicle that hovers sees the same part of a body through the same gap again and again. However many frames it takes
there, they count as one: sums are kept per vantage point, and each counts by the mean of its frames.

A point at height z above the focal plane appears displaced by z times the slope of its line of sight. The covariance of
what a frame shows is therefore that of the body seen from above, plus the variance of its heights along the slope:

    C = S + s² g gᵀ

Frames from several sides tell both parts apart by least squares: a standing person is small from above and stretched
towards every frame's edge, an animal is long in one direction on the map, whoever looks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.persons.warm_bodies import WarmView

MIN_VANTAGE_POINTS = 4
"""Vantage points from which on a form is told."""
APART_M = 2.0
"""Size of the cell within which the places of one vehicle are one vantage point: a projected twig wide or more."""
MAX_VANTAGE_POINTS = 120
"""Vantage points whose frames are kept, the latest ones: as many places of ten vehicles as a close look takes."""
MIN_PIXELS = 3
"""Warm pixels of a frame that tell more than that something is there: the fewest that have two axes."""
MAX_EXTENT_M = 2.5
"""Extent of what one frame shows from which it is more than one body."""
_GAP_M2 = 0.012
"""Area of a body that is seen through one gap between leaves; a larger pixel counts as one."""
_FEWEST_GAPS = 2.2
"""Gaps of a frame, in the mean, below which the correction for few of them grows no more."""
_UNIFORM = math.sqrt(12.0)
"""Length of something of even density over its standard deviation."""
_LEAST_M = 0.1
"""Least length and width: a pixel or two."""
_SCATTER_M2 = 0.10
"""Standard deviation of a frame's covariance of a single pixel: of n pixels it is smaller by the root of n."""
_PARTS_M, _LEAST_PARTS, _MOST_PARTS = 0.75, 0.4, 3.0
"""Length of a body that scatters as a pixel is said to, and limits of the factor for others: the parts of a longer one
that leaves show in one frame or another lie farther apart, so that it grows with the length squared."""
_HEIGHTS_M2, _HEIGHTS_SIGMA_M2 = 0.08, 0.12
"""Mean and standard deviation of the variance of heights before anything is seen: bodies of 0 to 1.8 m."""
_BIN_K = 0.25
_BINS = 160
"""Contrasts up to 40 K; what is hotter than any skin counts in the last bin."""
_OUT_OF_FOCUS_SPREAD = 1.7
"""Spread of contrasts in sharpened images of optics out of focus over that in others: the edges of spots between leaves
stay cooler than their middles."""
_EDGES_K = _BIN_K * np.arange(_BINS + 1)


@dataclass(frozen=True, slots=True)
class Form:
    """Size and warmth of a body."""

    vantage_points: int
    """Places of vehicles whose frames it rests on."""
    length_m: float
    """Length seen from above, of what the frames show of it: leaves shorten it."""
    width_m: float
    heights_m2: float
    """Variance of the heights of what is seen; below zero by chance where it is flat."""
    heights_sigma_m2: float
    """Standard deviation of that variance."""
    spread_k: float
    """Contrast of the warmest hundredth above the middle: skin, or an animal's head and legs."""
    hot_share: float
    """Share of its pixels that are nearer to the warmest than to the middle."""
    out_of_focus: float = 0.0
    """Share of its pixels in frames whose optics were out of focus, where patterns are others."""
    in_sun: float = 0.0
    """Share of its pixels in frames of days on which the sun warms things in spots."""
    fineness: float = 1.0
    """Area of a gap between leaves over that of a pixel, where pixels are coarser; else 1."""

    @property
    def height_m(self) -> float:
        """Height of an upright body of even density with such heights."""
        return _UNIFORM * math.sqrt(max(self.heights_m2, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class _Sums:
    """Sums over frames; one pixel weighs as much as any other."""

    frames: float
    weight: float
    moments_m2: NDArray[np.float64]
    """Weighted covariances of pixels: east, east and north, north."""
    slopes: NDArray[np.float64]
    """Weighted products of the lines' slopes, alike."""
    slopes_squared: float
    moments_by_slopes_m2: float
    counts: NDArray[np.float64]
    """Pixels per bin of contrast."""
    out_of_focus: float
    """Weight of the frames whose optics were out of focus."""
    in_sun: float
    """Weight of the frames in which the sun warms leaves and ground."""
    gaps: float
    """Gaps between leaves that the pixels are seen through."""
    fine: float
    """Weight of the frames, each times how fine its pixels are."""

    def __add__(self, other: _Sums) -> _Sums:
        """Return the sums over the frames of both."""
        return _Sums(*(getattr(self, name) + getattr(other, name) for name in _NAMES))

    def mean(self) -> _Sums:
        """Return the same as of one frame."""
        return _Sums(*(getattr(self, name) / self.frames for name in _NAMES))


_NAMES = tuple(one.name for one in fields(_Sums))


@dataclass(frozen=True, slots=True, eq=False)
class FormSums:
    """What frames tell about a body's form, by the vantage points that they were taken from."""

    sums: Mapping[tuple[int, int, int], _Sums] = field(default_factory=dict)
    """Sums by vehicle and cell, east and north; the latest vantage points are the last."""

    def __add__(self, other: FormSums) -> FormSums:
        """Return what the frames of both tell; the later ones are the other's."""
        together = {key: one for key, one in self.sums.items() if key not in other.sums}
        for key, one in other.sums.items():
            former = self.sums.get(key)
            together[key] = one if former is None else former + one
        return FormSums(dict(list(together.items())[-MAX_VANTAGE_POINTS:]))

    def form(self) -> Form | None:
        """Return the form; None where too few vantage points show enough of the body."""
        if len(self.sums) < MIN_VANTAGE_POINTS:
            return None
        seen = reduce(add, (one.mean() for one in self.sums.values()))
        whole = _of_the_whole(seen.gaps / len(self.sums))
        prior = (_SCATTER_M2 / _HEIGHTS_SIGMA_M2) ** 2
        of_slopes = seen.slopes_squared - float(seen.slopes @ seen.slopes) / seen.weight
        information = of_slopes + prior
        seen_m2 = seen.moments_by_slopes_m2 - float(seen.moments_m2 @ seen.slopes) / seen.weight
        heights_m2 = (whole * seen_m2 + prior * _HEIGHTS_M2) / information
        east_m2, mixed_m2, north_m2 = (whole * seen.moments_m2 - heights_m2 * seen.slopes) / seen.weight
        minor_m2, major_m2 = np.linalg.eigvalsh([[east_m2, mixed_m2], [mixed_m2, north_m2]])
        length_m = max(_UNIFORM * math.sqrt(max(float(major_m2), 0.0)), _LEAST_M)
        parts = min(max((length_m / _PARTS_M) ** 2, _LEAST_PARTS), _MOST_PARTS)
        below = np.concatenate(([0], np.cumsum(seen.counts))) / seen.counts.sum()
        middle_k, warmest_k = np.interp([0.5, 0.99], below, _EDGES_K)
        out_of_focus = seen.out_of_focus / seen.weight
        return Form(
            vantage_points=len(self.sums),
            length_m=length_m,
            width_m=max(_UNIFORM * math.sqrt(max(float(minor_m2), 0.0)), _LEAST_M),
            heights_m2=float(heights_m2),
            heights_sigma_m2=_SCATTER_M2 * math.sqrt(parts**2 * of_slopes + prior) / information,
            spread_k=float(warmest_k - middle_k) / (1.0 + (_OUT_OF_FOCUS_SPREAD - 1.0) * out_of_focus),
            hot_share=1.0 - float(np.interp((middle_k + warmest_k) / 2.0, _EDGES_K, below)),
            out_of_focus=out_of_focus,
            in_sun=seen.in_sun / seen.weight,
            fineness=seen.fine / seen.weight,
        )


def _of_the_whole(gaps: float) -> float:
    """Return the variance of the places of a body over that of what a frame shows of it, about its own middle.

    The fewer gaps between leaves a frame sees it through, the nearer to their middle they lie, as any few samples do.
    """
    return 1.0 / (1.0 - 1.0 / max(gaps, _FEWEST_GAPS))


def form_sums(body: Sequence[WarmView], plane_height_m: float) -> FormSums:
    """Return what the views of one body tell, of those with temperatures and of cameras that hover.

    Args:
        body: the parts of the views that show it.
        plane_height_m: ENU height of the focal plane that their points lie on.
    """
    views = [
        view
        for view in body
        if view.radiometric
        and not view.is_smeared
        and len(view.points_enu_m) >= MIN_PIXELS
        and np.ptp(view.points_enu_m, axis=0).max() <= MAX_EXTENT_M
    ]
    if not views:
        return FormSums()
    pixels = np.array([len(view.points_enu_m) for view in views])
    starts = np.cumsum(pixels) - pixels
    points_enu_m = np.concatenate([view.points_enu_m for view in views])
    middles_enu_m = np.add.reduceat(points_enu_m, starts) / pixels[:, None]
    east_m, north_m = (points_enu_m - np.repeat(middles_enu_m, pixels, axis=0)).T
    moments_m2 = np.add.reduceat(np.column_stack((east_m**2, east_m * north_m, north_m**2)), starts)
    cameras_enu_m = np.array([view.pose.position_enu_m for view in views])
    east, north = ((middles_enu_m - cameras_enu_m[:, :2]) / (cameras_enu_m[:, 2:] - plane_height_m)).T
    slopes = np.column_stack((east**2, east * north, north**2))
    contrast_k = np.concatenate([view.contrast_k for view in views])
    bins = np.clip((contrast_k / _BIN_K).astype(np.int64), 0, _BINS - 1)
    bins += _BINS * np.repeat(np.arange(len(views)), pixels)
    counts = np.bincount(bins, minlength=_BINS * len(views)).reshape(-1, _BINS).astype(np.float64)
    cells = np.floor(cameras_enu_m[:, :2] / APART_M).astype(np.int64).tolist()
    told: dict[tuple[int, int, int], _Sums] = {}
    for row, (view, (column, line)) in enumerate(zip(views, cells, strict=True)):
        weight = float(pixels[row])
        one = _Sums(
            frames=1.0,
            weight=weight,
            moments_m2=moments_m2[row],
            slopes=weight * slopes[row],
            slopes_squared=weight * float(slopes[row] @ slopes[row]),
            moments_by_slopes_m2=float(moments_m2[row] @ slopes[row]),
            counts=counts[row],
            out_of_focus=weight * view.out_of_focus,
            in_sun=weight * view.in_sun,
            gaps=weight * min(view.pixel_area_m2 / _GAP_M2, 1.0),
            fine=weight * min(_GAP_M2 / view.pixel_area_m2, 1.0),
        )
        key = (view.vehicle_id, column, line)
        told[key] = told[key] + one if key in told else one
    return FormSums(told)
