"""The smooth surface above the ground that all altitude layers of a mission are offset from.

At every place all layers are shifted by the same height, so that they stay as far apart as on level ground. The surface
is never below the ground, nowhere steeper than vehicles climb and descend, and bent so little that a short straight
segment stays near it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.terrain import GroundRaster

FloatArray = NDArray[np.float64]

RADIUS_M = 10.0
"""Distance, along east and north, up to which no ground is above the surface at a place."""
BEND_M = 10.0
"""Distance, along east and north, over which the slope is averaged."""
STRAIGHT_M = 0.25
"""Greatest distance above or below the surface of a straight piece of a way along it. With layers of 2 m and RTK,
vehicles in neighbouring layers still pass one another."""
FINEST_STEP_M = 4.0
MAX_NODES = 250_000
_SAMPLE_M = 2.0


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """Heights above the origin, bilinear between nodes, and constant beyond the outermost ones."""

    west_m: float
    south_m: float
    step_m: float
    heights_m: FloatArray
    """Heights at the nodes, shape (rows, columns); rows go north, columns east."""

    @cached_property
    def lowest_m(self) -> float:
        """Height of its lowest place."""
        return float(self.heights_m.min())

    @cached_property
    def highest_m(self) -> float:
        """Height of its highest place."""
        return float(self.heights_m.max())

    @property
    def is_level(self) -> bool:
        """Whether it has the same height everywhere."""
        return self.lowest_m == self.highest_m

    def height_m(self, places_enu_m: FloatArray) -> FloatArray:
        """Return the heights above the origin at places, shape (n, 2)."""
        rows, columns = self.heights_m.shape
        row = np.clip((places_enu_m[:, 1] - self.south_m) / self.step_m, 0.0, rows - 1.0)
        column = np.clip((places_enu_m[:, 0] - self.west_m) / self.step_m, 0.0, columns - 1.0)
        top = np.minimum(row.astype(np.int64), max(0, rows - 2))
        left = np.minimum(column.astype(np.int64), max(0, columns - 2))
        below, right = np.minimum(top + 1, rows - 1), np.minimum(left + 1, columns - 1)
        up, along = row - top, column - left
        heights_m = self.heights_m
        west_m = (1.0 - up) * heights_m[top, left] + up * heights_m[below, left]
        east_m = (1.0 - up) * heights_m[top, right] + up * heights_m[below, right]
        return np.asarray((1.0 - along) * west_m + along * east_m)

    def at(self, place_enu_m: FloatArray) -> float:
        """Return the height above the origin at a place; its first two coordinates count."""
        if self.is_level:
            return self.lowest_m
        return float(self.height_m(np.asarray(place_enu_m, dtype=np.float64)[None, :2])[0])

    def straight_share(self, start_enu_m: FloatArray, end_enu_m: FloatArray) -> float:
        """Return up to which share of a way a straight line between places on the surface stays near it.

        Args:
            start_enu_m: start of the way; the first two coordinates count.
            end_enu_m: its end.
        """
        if self.is_level:
            return 1.0
        way_m = np.asarray(end_enu_m[:2] - start_enu_m[:2], dtype=np.float64)
        count = math.ceil(float(np.hypot(*way_m)) / _SAMPLE_M)
        if count < 2:
            return 1.0
        shares = np.arange(1, count + 1) / count
        rises_m = self.height_m(start_enu_m[:2] + shares[:, None] * way_m) - self.at(start_enu_m)
        # Lines from the start that are near the surface at all samples up to each.
        least = np.maximum.accumulate((rises_m - STRAIGHT_M) / shares)
        most = np.minimum.accumulate((rises_m + STRAIGHT_M) / shares)
        slopes = rises_m / shares
        return float(shares[np.flatnonzero((least <= slopes) & (slopes <= most))[-1]])


LEVEL = ReferenceSurface(0.0, 0.0, FINEST_STEP_M, np.zeros((1, 1)))
"""The surface of layers that do not follow the ground: level, at the height of the origin."""


def reference_surface(
    ground: GroundRaster, bounds_enu_m: tuple[float, float, float, float], max_slope: float
) -> ReferenceSurface:
    """Return the lowest such surface within a rectangle, as nodes resolve it.

    Args:
        ground: ground below it; where that is not known, the surface goes on from where it is.
        bounds_enu_m: west, south, east and north end, metres.
        max_slope: greatest slope, above 0.
    """
    west_m, south_m, east_m, north_m = bounds_enu_m
    step_m = max(FINEST_STEP_M, math.sqrt((east_m - west_m) * (north_m - south_m) / MAX_NODES))
    columns, rows = (math.ceil(side_m / step_m) + 1 for side_m in (east_m - west_m, north_m - south_m))
    east, north = np.meshgrid(west_m + step_m * np.arange(columns), south_m + step_m * np.arange(rows))
    nodes_m = np.column_stack((east.ravel(), north.ravel()))
    bend = math.ceil(BEND_M / step_m)
    # A place is within a step of the nodes around it, and these are averages of nodes within the bend.
    reach_m = RADIUS_M + (bend + 1) * step_m
    heights_m = ground.highest_around(nodes_m, reach_m).reshape(rows, columns)
    known = np.isfinite(heights_m)
    if not known.any():
        return ReferenceSurface(west_m, south_m, step_m, np.zeros((rows, columns)))
    # Along each axis alone, as slopes along both add up to the square root of two of either.
    rise_m = max_slope / math.sqrt(2.0) * step_m
    lifted_m = np.where(known, heights_m, -np.inf)
    for axis in (0, 1):
        lifted_m = _cones(lifted_m, rise_m, axis)
    smooth_m = cv2.blur(lifted_m, (2 * bend + 1, 2 * bend + 1), borderType=cv2.BORDER_REPLICATE)
    return ReferenceSurface(west_m, south_m, step_m, np.asarray(smooth_m, dtype=np.float64))


def _cones(heights_m: FloatArray, rise_m: float, axis: int) -> FloatArray:
    """Return the least heights, not below those given, that differ by at most ``rise_m`` along an axis."""
    count = heights_m.shape[axis]
    ramp_m = rise_m * np.arange(count, dtype=np.float64).reshape((-1, 1) if axis == 0 else (1, -1))
    forward_m = np.maximum.accumulate(heights_m + ramp_m, axis=axis) - ramp_m
    back_m = np.flip(np.maximum.accumulate(np.flip(heights_m - ramp_m, axis), axis=axis), axis) + ramp_m
    return np.maximum(forward_m, back_m)
