"""Accuracies of positions, and how much farther apart two vehicles have to stay because of them.

Two reported positions may both be wrong. What they may be wrong by together is taken as a cylinder, ``CONFIDENCE``
standard deviations wide and high; vehicles keep their separation from each other wherever in it they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CONFIDENCE: Final = 2.0
"""Factor between an accuracy, which is a standard deviation, and the error that is taken into account."""
_OVERSHOOT_M = 0.1
"""Height by which the ellipsoid of :func:`clearances` exceeds what it encloses: without it, it would be endlessly
wide."""
_UNDER_WAY_M: Final = 0.6
"""Height by which two vehicles under way come nearer to each other than their layers are, in gusts: what simulated ones
stay within at 999 of 1000 moments, on legs of 40 m at the search speed in a wind of 3 m/s."""
_SLOPES = np.geomspace(1e-3, 1.0, 64)
_ROUNDING = 1.01
_EXACT_M = 1e-9


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Standard deviations of a position."""

    horizontal_m: float
    vertical_m: float


EXACT: Final = Accuracy(0.0, 0.0)


def joint_errors_m(one: Accuracy, other: Accuracy) -> tuple[float, float]:
    """Return the horizontal and vertical error taken into account in the offset between two positions."""
    horizontal_m = math.hypot(one.horizontal_m, other.horizontal_m)
    return CONFIDENCE * horizontal_m, CONFIDENCE * math.hypot(one.vertical_m, other.vertical_m)


def beside_errors_m(accuracy: Accuracy) -> float:
    """Return how much farther than the separation two vehicles of this accuracy have to be beside each other."""
    errors_m, _ = joint_errors_m(accuracy, accuracy)
    return errors_m + _OVERSHOOT_M if errors_m >= _EXACT_M else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """Half axes of ellipsoids, one per pair of vehicles, that the offset between their positions must lie outside of.

    An ellipsoid becomes a sphere when heights are scaled, so distances to segments need no other mathematics.
    """

    wide_m: FloatArray
    """Shape (n,)."""
    high_m: FloatArray
    """Shape (n,)."""

    def scale(self) -> FloatArray:
        """Return the factors of the coordinates, shape (n, 3), that make spheres of radius ``wide_m``."""
        ones = np.ones_like(self.wide_m)
        return np.column_stack([ones, ones, self.wide_m / self.high_m])


def clearances(separation_m: float, horizontal_m: FloatArray, vertical_m: FloatArray) -> tuple[Clearance, Clearance]:
    """Return two sets of ellipsoids; a path that stays outside of either one keeps the true separation.

    Both enclose the sphere of ``separation_m`` moved by every error within a cylinder: one is as low as that, the other
    one as narrow, for vehicles above and beside each other.

    Args:
        separation_m: smallest true distance.
        horizontal_m: radius of the cylinder, shape (n,).
        vertical_m: half of its height, shape (n,).
    """
    wide_m, high_m = _enclosing(separation_m, horizontal_m, vertical_m)
    tall_m, narrow_m = _enclosing(separation_m, vertical_m, horizontal_m)
    return Clearance(wide_m, high_m), Clearance(narrow_m, tall_m)


def _enclosing(
    separation_m: float, wide_error_m: FloatArray, high_error_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the half axes of ellipsoids that are hardly higher than what they enclose."""
    is_exact = (wide_error_m < _EXACT_M) & (high_error_m < _EXACT_M)
    if is_exact.all():
        exact_m = np.full(len(wide_error_m), separation_m)
        return exact_m, exact_m
    if len(wide_error_m) > 1 and (wide_error_m == wide_error_m[0]).all() and (high_error_m == high_error_m[0]).all():
        # A fleet of one kind: one pair stands for all.
        wide_m, high_m = _enclosing(separation_m, wide_error_m[:1], high_error_m[:1])
        return np.repeat(wide_m, len(wide_error_m)), np.repeat(high_m, len(wide_error_m))
    high_m = separation_m + high_error_m + _OVERSHOOT_M
    slope = _SLOPES[:, None]
    # Distance of the tangent plane of each slope from the centre: sphere and cylinder together, then the ellipsoid.
    reach_m = separation_m + np.sqrt(slope) * wide_error_m + np.sqrt(1.0 - slope) * high_error_m
    wide_m2 = ((reach_m**2 - (1.0 - slope) * high_m**2) / slope).max(axis=0)
    wide_m = np.maximum(separation_m + wide_error_m, _ROUNDING * np.sqrt(np.maximum(wide_m2, 0.0)))
    return np.where(is_exact, separation_m, wide_m), np.where(is_exact, separation_m, high_m)


def needed_spacing_m(separation_m: float, vertical_accuracy_m: float) -> float:
    """Return the least spacing of altitude layers for vehicles with this accuracy of altitude.

    Neighbours must be able to pass above each other, and an error must not reach the middle between two layers.
    """
    joint_m = CONFIDENCE * math.sqrt(2.0) * vertical_accuracy_m
    return max(2.0 * CONFIDENCE * vertical_accuracy_m, separation_m + joint_m + _OVERSHOOT_M + _UNDER_WAY_M)


def greatest_accuracy_m(separation_m: float, layer_spacing_m: float) -> float:
    """Return the worst accuracy of altitude that layers of this spacing bear; below 0 where they bear none."""
    joint_m = layer_spacing_m - separation_m - _OVERSHOOT_M - _UNDER_WAY_M
    return min(layer_spacing_m / (2.0 * CONFIDENCE), joint_m / (CONFIDENCE * math.sqrt(2.0)))


def allowed_offset_m(separation_m: float, layer_spacing_m: float) -> float:
    """Return by how much a vehicle may be above or below its layer for long, so that all keep the separation."""
    return max(0.0, layer_spacing_m - separation_m - _UNDER_WAY_M) / 2.0
