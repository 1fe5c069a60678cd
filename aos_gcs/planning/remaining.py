"""The part of a search area that a sortie has left for the next one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon, as_points, as_polygon, edges
from aos_gcs.errors import ConfigurationError
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.swarm.line import line_axis

_SAME_M = 1e-6
"""Distance up to which two corners are one."""
_SAME_STRIP_M = 0.5
"""Distance across up to which two legs are parts of one strip."""
_SHORTEST_M = 5.0
"""Rest of the last leg that is not worth another flight."""


def remaining_area(
    area_enu_m: Polygon, legs: Sequence[ScanLeg], leg: int, along_m: float, passes: int = 1
) -> Polygon | None:
    """Return the part of an area that the legs not yet flown cover; None if nothing is left of it.

    A leg that was begun is flown again as a whole, but for the last one. Where what is left cannot be told as one
    polygon, as of an area with deep bays, it is the whole area. Where legs are not flown to and fro, it is the part
    from the first to the last strip that has a leg left.

    Args:
        area_enu_m: search area.
        legs: legs of all passes, in the order in which they are flown; none before they are planned.
        leg: index of the first leg not flown to its end.
        along_m: distance flown on it.
        passes: number of passes; before the last one the whole area is left.
    """
    before_last = len(legs) // passes * (passes - 1)
    legs, leg = legs[before_last:], leg - before_last
    if not legs or leg < 0 or (leg == 0 and len(legs) > 1):
        return area_enu_m
    if leg >= len(legs):
        return None
    present = legs[leg]
    direction = np.array(present.direction_enu)
    if leg == len(legs) - 1 and present.length_m - along_m < _SHORTEST_M:
        return None
    if not _are_neighbours(legs):
        return _of_strips(area_enu_m, legs, leg)
    if leg == len(legs) - 1:
        inwards, from_m = direction, float(np.array(present.start_enu_m) @ direction) + along_m
        area_enu_m = _clipped(area_enu_m, inwards, from_m)
    if leg == 0:
        return area_enu_m
    across = line_axis(direction)
    before_m, here_m = (float(np.array(one.start_enu_m) @ across) for one in (legs[leg - 1], present))
    inwards = across if here_m > before_m else -across
    return _clipped(area_enu_m, inwards, float(np.sign(here_m - before_m)) * (before_m + here_m) / 2.0)


def _are_neighbours(legs: Sequence[ScanLeg]) -> bool:
    """Return whether legs lie one beside the other in the order in which they are flown."""
    across_m = _across_m(legs)
    steps_m = np.diff(across_m)
    return bool((steps_m > _SAME_STRIP_M).all() or (steps_m < -_SAME_STRIP_M).all())


def _across_m(legs: Sequence[ScanLeg]) -> NDArray[np.float64]:
    across = line_axis(np.array(legs[0].direction_enu))
    return np.array([leg.start_enu_m for leg in legs]) @ across


def _of_strips(area_enu_m: Polygon, legs: Sequence[ScanLeg], leg: int) -> Polygon:
    """Return the part of an area from the first to the last strip that has a leg left."""
    across, across_m = line_axis(np.array(legs[0].direction_enu)), _across_m(legs)
    strips_m = np.sort(across_m)
    apart_m = np.diff(strips_m)
    apart_m = apart_m[apart_m > _SAME_STRIP_M]
    if not len(apart_m):
        return area_enu_m  # parts of one strip
    half_m, left_m = float(apart_m.min()) / 2.0, across_m[leg:]
    if left_m.min() > strips_m[0] + half_m:
        area_enu_m = _clipped(area_enu_m, across, float(left_m.min()) - half_m)
    if left_m.max() < strips_m[-1] - half_m:
        area_enu_m = _clipped(area_enu_m, -across, -float(left_m.max()) - half_m)
    return area_enu_m


def _clipped(area_enu_m: Polygon, inwards: NDArray[np.float64], from_m: float) -> Polygon:
    """Return the part of a polygon whose projection on the unit vector ``inwards`` is ``from_m`` or more."""
    kept: list[tuple[float, float]] = []
    for start_m, end_m in zip(*edges(np.array(area_enu_m, dtype=np.float64)), strict=True):
        start_in_m, end_in_m = float(start_m @ inwards) - from_m, float(end_m @ inwards) - from_m
        if start_in_m >= 0.0:
            kept.append(_point(start_m))
        if (start_in_m >= 0.0) != (end_in_m >= 0.0):
            kept.append(_point(start_m + start_in_m / (start_in_m - end_in_m) * (end_m - start_m)))
    # Where the edge of a former clip meets this one, two corners differ by no more than rounding.
    corners = [place for index, place in enumerate(kept) if math.dist(place, kept[index - 1]) > _SAME_M]
    try:
        return as_points(as_polygon(corners, "area_enu_m"))
    except ConfigurationError:
        return area_enu_m


def _point(place_m: NDArray[np.float64]) -> tuple[float, float]:
    return float(place_m[0]), float(place_m[1])
