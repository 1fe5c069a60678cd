"""Geometry of the cameras about a region: the depth of field, and which cameras are compared."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.focus.measure import MAX_GROUPS
from aos_gcs.imaging.focus.region import FocusRegion
from aos_gcs.imaging.model import Frame

MAX_SLOPE = math.tan(math.radians(30.0))
"""Steepest ground."""

COMMON_SIGMA_M = 0.4
"""Standard deviation of heights by what all frames have in common: errors of the poses, and things on the ground."""

MIN_PARALLAX = 0.1
"""Distance of two cameras, as a share of their distance to the region, from which their frames are compared."""

MIN_SPREAD_GROUPS = 4.0
"""Groups that an aperture smaller than that is divided into."""


@dataclass(frozen=True, slots=True)
class FocusGeometry:
    """Geometry that determines the depth of field."""

    sampling_m: float
    """Ground sampling distance at the region."""
    spread: float
    """Spread of the cameras about the region: metres on the plane by which frames part per metre of height."""
    distance_m: float
    """Depth of the region below the cameras."""
    cameras: int

    @property
    def separation_m(self) -> float:
        """Distance from which frames of two cameras are compared: nearer ones see crowns alike on any surface.

        0 for a few cameras: there all pairs are needed.
        """
        if self.cameras <= MAX_GROUPS:
            return 0.0
        return self.distance_m * min(MIN_PARALLAX, self.spread / MIN_SPREAD_GROUPS)

    def step_m(self, reduction: int) -> float:
        """Height in which the outermost frames part by the width of the structure that the filter lets through."""
        return 2.0 * reduction * self.sampling_m / self.spread if self.spread > 0.0 else math.inf


def focus_geometry(frames: Iterable[Frame], region: FocusRegion, height_m: float) -> FocusGeometry:
    """Return the geometry of a region's view; it raises an ``ImagingError`` if fewer than two cameras look at it."""
    centre_m = region.centre_m(height_m)
    samplings_m, directions, depths_m = [], [], []
    for frame in frames:
        gap_m = centre_m - frame.pose.position_enu_m
        depth_m = float(gap_m @ frame.pose.R_cam2enu[:, 2])
        if depth_m > 0.0 and gap_m[2] != 0.0:
            samplings_m.append(depth_m / frame.camera.fx_px)
            directions.append(gap_m[:2] / gap_m[2])
            depths_m.append(depth_m)
    if len(directions) < 2:
        raise ImagingError(
            f"Fewer than two cameras have the region to focus on in front of them at a height of {height_m:g} m: "
            "choose another region or range."
        )
    variance = np.linalg.eigvalsh(np.cov(np.array(directions).T)).max()
    # A line of evenly spaced cameras is sqrt(12) times as long as its standard deviation.
    spread = math.sqrt(12.0 * max(float(variance), 0.0))
    return FocusGeometry(float(np.median(samplings_m)), spread, float(np.median(depths_m)), len(depths_m))
