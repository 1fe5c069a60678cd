"""Fence of a simulated vehicle, from its parameters and the uploaded polygons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from aos_sim.vehicle.kinematics import EnuPoint

Ring = tuple[tuple[float, float], ...]
"""Corners of a polygon, metres east and north."""


@dataclass(frozen=True, slots=True)
class Fence:
    """A cylinder about home, polygons to stay in and polygons to stay out of; infinite where it is switched off."""

    radius_m: float = math.inf
    ceiling_m: float = math.inf
    inclusions_enu_m: tuple[Ring, ...] = ()
    exclusions_enu_m: tuple[Ring, ...] = ()

    def breach(self, point_enu_m: EnuPoint, home_enu_m: EnuPoint) -> str | None:
        """Return which limit a point lies beyond, in the autopilots' words, or None inside."""
        place_enu_m = point_enu_m[:2]
        if point_enu_m[2] - home_enu_m[2] > self.ceiling_m:
            return "Max Alt"
        if math.dist(place_enu_m, home_enu_m[:2]) > self.radius_m:
            return "Circle"
        is_outside = not all(is_inside(place_enu_m, ring) for ring in self.inclusions_enu_m)
        if is_outside or any(is_inside(place_enu_m, ring) for ring in self.exclusions_enu_m):
            return "Polygon"
        return None


def is_inside(point: tuple[float, float], ring: Sequence[tuple[float, float]]) -> bool:
    """Whether a ray from the point towards east crosses the polygon's edges an odd number of times."""
    east, north = point
    inside = False
    for (east_1, north_1), (east_2, north_2) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (north_1 > north) != (north_2 > north):
            crossing_east = east_1 + (north - north_1) * (east_2 - east_1) / (north_2 - north_1)
            inside ^= east < crossing_east
    return inside
