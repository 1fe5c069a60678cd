"""Search for the offset at which a region is in focus on a terrain of known shape.

The terrain is a prior in two ways: its shape, as ground on a slope is in focus on no level plane, and its height, which
is off by the errors of the elevation model and of the poses only. Under crowns the frames alone seldom decide.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.focus.autofocus import (
    FINEST_REDUCTION,
    MAX_SCAN_HEIGHTS,
    FocusCurve,
    focus_curve,
)
from aos_gcs.imaging.focus.fixed_pattern import without_pattern
from aos_gcs.imaging.focus.geometry import focus_geometry
from aos_gcs.imaging.focus.region import FocusRegion
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.terrain import Terrain

TERRAIN_SIGMA_M = 1.5
"""Standard deviation of a terrain's height in the world of the poses, before the frames have been compared."""

MIN_SIGMA_M = 0.8
"""Smallest standard deviation of the offset: neither models nor poses are exact over a whole view.

In 15 windows of a recorded flight whose poses had been corrected, the root mean square of the errors was 0.85 m.
"""

STEPS_PER_SIGMA = 2.0

OUT_OF_FOCUS_QUANTILE = 0.25
"""Quantile of the agreements over the range that is taken for that of a terrain out of focus."""

FREE_OF_FRAMES = 0.9
"""Share of the prior's standard deviation above which the frames have said nothing."""


@dataclass(frozen=True, slots=True)
class TerrainFocus:
    """Offset along z at which a region is in focus on a terrain."""

    offset_m: float
    sigma_m: float
    """Standard deviation of the offset."""
    by_frames: bool
    """Whether the frames tell more than the terrain's own height does."""


def find_terrain_focus(
    frames: Iterable[Frame], region: FocusRegion, terrain: Terrain, low_m: float, high_m: float
) -> TerrainFocus:
    """Find the offset of a terrain that a region is in focus on.

    Args:
        frames: at least two, all with the same bands. They are gone through a few times, one after the other.
        region: points to compare.
        terrain: ground in the world of the poses; it is off by ``TERRAIN_SIGMA_M``.
        low_m: smallest offset along z.
        high_m: greatest offset.

    Raises:
        ImagingError: if the range is not one, there are fewer than two frames, or the terrain is not in the region.
    """
    if not (math.isfinite(low_m) and math.isfinite(high_m) and low_m < high_m):
        raise ImagingError(f"The range of offsets must be finite and ascending, got {low_m:g} to {high_m:g} m.")
    heights_m = region.points_m(terrain)[:, 2]
    if not np.isfinite(heights_m).any():
        raise ImagingError("The region to focus on does not lie on the terrain.")
    geometry = focus_geometry(frames, region, float(np.nanmedian(heights_m)))
    step_m = min(geometry.step_m(FINEST_REDUCTION), TERRAIN_SIGMA_M) / STEPS_PER_SIGMA
    count = min(math.ceil((high_m - low_m) / step_m) + 1, MAX_SCAN_HEIGHTS)
    offsets_m = np.linspace(low_m, high_m, max(count, 3))
    curve = focus_curve(
        without_pattern(frames, geometry.separation_m),
        region,
        [terrain.moved(float(offset_m)) for offset_m in offsets_m],
        reduction=FINEST_REDUCTION,
        separation_m=geometry.separation_m,
    )
    return judge_offsets(offsets_m, curve)


def judge_offsets(offsets_m: NDArray[np.float64], curve: FocusCurve) -> TerrainFocus:
    """Return mean and standard deviation of the offset given the agreement at evenly spaced offsets.

    The agreement of a plane that is in focus is not known beforehand. At its most likely value the logarithm of the
    likelihood is half the square of how far an offset rises above what is common to all of them, in standard
    deviations of chance.
    """
    prior = -0.5 * (offsets_m / TERRAIN_SIGMA_M) ** 2
    rise = np.zeros_like(prior)
    if math.isfinite(curve.scatter):
        rise = np.maximum(curve.values - np.quantile(curve.values, OUT_OF_FOCUS_QUANTILE), 0.0) / curve.scatter
    offset_m, sigma_m = _moments(offsets_m, prior + 0.5 * rise**2)
    _, prior_sigma_m = _moments(offsets_m, prior)
    by_frames = sigma_m < FREE_OF_FRAMES * prior_sigma_m
    return TerrainFocus(offset_m, max(sigma_m, MIN_SIGMA_M), by_frames)


def _moments(values: NDArray[np.float64], log_density: NDArray[np.float64]) -> tuple[float, float]:
    """Return mean and standard deviation of values by their densities."""
    weights = np.exp(log_density - log_density.max())
    weights /= weights.sum()
    mean = float(weights @ values)
    return mean, math.sqrt(float(weights @ (values - mean) ** 2))
