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
_SHORTEST_M = 5.0
"""Rest of the last leg that is not worth another flight."""


def remaining_area(area_enu_m: Polygon, legs: Sequence[ScanLeg], leg: int, along_m: float) -> Polygon | None:
    """Return the part of an area that the legs not yet flown cover; None if nothing is left of it.

    A leg that was begun is flown again as a whole, but for the last one. Where what is left cannot be told as one
    polygon, as of an area with deep bays, it is the whole area.

    Args:
        area_enu_m: search area.
        legs: legs of the whole area, to and fro; none before they are planned.
        leg: index of the first leg not flown to its end.
        along_m: distance flown on it.
    """
    if not legs or (leg == 0 and len(legs) > 1):
        return area_enu_m
    if leg >= len(legs):
        return None
    present = legs[leg]
    direction = np.array(present.direction_enu)
    if leg == len(legs) - 1:
        if present.length_m - along_m < _SHORTEST_M:
            return None
        inwards, from_m = direction, float(np.array(present.start_enu_m) @ direction) + along_m
        area_enu_m = _clipped(area_enu_m, inwards, from_m)
    if leg == 0:
        return area_enu_m
    across = line_axis(direction)
    before_m, here_m = (float(np.array(one.start_enu_m) @ across) for one in (legs[leg - 1], present))
    inwards = across if here_m > before_m else -across
    return _clipped(area_enu_m, inwards, float(np.sign(here_m - before_m)) * (before_m + here_m) / 2.0)


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
