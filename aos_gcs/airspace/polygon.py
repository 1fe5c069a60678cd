"""Polygons on the ground: search areas, fences and no-go zones, in horizontal ENU metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.separation import TOLERANCE_M, near_pairs, point_segment_distance, segment_distance
from aos_gcs.errors import ConfigurationError

FloatArray = NDArray[np.float64]
Polygon = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Boundary:
    """The edge of a polygon that vehicles stay inside of, such as a geofence, or outside of, such as a no-go zone."""

    vertices_m: FloatArray
    """Shape (m, 2), metres."""
    name: str
    keeps_in: bool
    margin_m: float = 0.0
    """Distance to keep from the edge on the allowed side."""

    def depth_m(self, point_m: FloatArray) -> float:
        """Return how far a point, shape (2,), lies on the allowed side of the edge; negative on the other."""
        return float(self.depths_m(point_m[None])[0])

    def depths_m(self, points_m: FloatArray) -> FloatArray:
        """Return the same for each of many points, shape (n, 2)."""
        depths_m = signed_depths_m(points_m, self.vertices_m)
        return depths_m if self.keeps_in else -depths_m

    @property
    def trespass(self) -> str:
        """Reason for holding a vehicle on the wrong side."""
        if self.keeps_in:
            return f"it is outside {self.name} and would not fly straight back inside"
        return f"it is inside {self.name} and would not fly straight out of it"


def as_polygon(points: Sequence[Sequence[float]], field: str) -> FloatArray:
    """Return a simple polygon's vertices, shape (m, 2), without repetitions, such as of the first one at the end.

    Args:
        points: vertices in order, clockwise or counter-clockwise, metres.
        field: name of the setting, for the error's text.

    Raises:
        ConfigurationError: fewer than three vertices, not finite, no area, or edges that cross.
    """
    vertices_m: FloatArray = np.array(points, dtype=np.float64)
    if vertices_m.ndim != 2 or vertices_m.shape[1] != 2 or not np.isfinite(vertices_m).all():
        raise ConfigurationError(f"{field} must be a list of points with two finite coordinates each, in metres.")
    repeated = (vertices_m == np.roll(vertices_m, 1, axis=0)).all(axis=1)
    vertices_m = vertices_m[~repeated]
    if len(vertices_m) >= 3 and _has_crossing_edges(vertices_m):
        raise ConfigurationError(f"{field} must not cross or touch itself; list its points in order along the edge.")
    if len(vertices_m) < 3 or abs(signed_area_m2(vertices_m)) < TOLERANCE_M:
        raise ConfigurationError(f"{field} must have three or more points that enclose an area.")
    return vertices_m


def as_points(vertices_m: FloatArray) -> Polygon:
    """Return vertices, shape (m, 2), as plain tuples."""
    return tuple((float(east_m), float(north_m)) for east_m, north_m in vertices_m)


def signed_area_m2(vertices_m: FloatArray) -> float:
    """Return the enclosed area, positive when the vertices run counter-clockwise."""
    east_m, north_m = (vertices_m - vertices_m[0]).T
    return 0.5 * float(east_m @ np.roll(north_m, -1) - north_m @ np.roll(east_m, -1))


def edges(vertices_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the starts and the ends of the edges, shape (m, 2) each."""
    return vertices_m, np.concatenate((vertices_m[1:], vertices_m[:1]))


def signed_depth_m(point_m: FloatArray, vertices_m: FloatArray) -> float:
    """Return how deep a point, shape (2,), lies inside: its distance to the edge, negative outside."""
    return float(signed_depths_m(point_m[None], vertices_m)[0])


def signed_depths_m(points_m: FloatArray, vertices_m: FloatArray) -> FloatArray:
    """Return how deep each of many points, shape (n, 2), lies inside, as :func:`signed_depth_m`."""
    distances_m = point_segment_distance(points_m[:, None], *edges(vertices_m))[0].min(axis=1)
    return np.asarray(np.where(_contained(points_m, vertices_m), distances_m, -distances_m))


def contains(point_m: FloatArray, vertices_m: FloatArray) -> bool:
    """Return whether a point, shape (2,), lies inside."""
    return bool(_contained(point_m[None], vertices_m)[0])


def _contained(points_m: FloatArray, vertices_m: FloatArray) -> NDArray[np.bool_]:
    """Return which points, shape (n, 2), lie inside: a ray to the east meets the edge an odd number of times."""
    starts, ends = edges(vertices_m)
    east_m, north_m = points_m[:, :1], points_m[:, 1:]
    spans = (starts[:, 1] > north_m) != (ends[:, 1] > north_m)
    rise_m = np.where(spans, ends[:, 1] - starts[:, 1], 1.0)
    crossing_east_m = starts[:, 0] + (north_m - starts[:, 1]) / rise_m * (ends[:, 0] - starts[:, 0])
    return np.asarray(np.count_nonzero(spans & (east_m < crossing_east_m), axis=1) % 2 == 1)


def edges_met(start_m: FloatArray, end_m: FloatArray, vertices_m: FloatArray) -> int:
    """Return how many edges the straight segment between two points meets."""
    starts, ends = edges(vertices_m)
    return int(np.count_nonzero(segment_distance(start_m, end_m, starts, ends) < TOLERANCE_M))


def _has_crossing_edges(vertices_m: FloatArray) -> bool:
    starts, ends = edges(vertices_m)
    first, second = near_pairs(starts, ends, starts, ends, TOLERANCE_M)
    # Neighbours meet where they should.
    steps = (second - first) % len(vertices_m)
    apart = (first < second) & (steps != 1) & (steps != len(vertices_m) - 1)
    first, second = first[apart], second[apart]
    gaps_m = segment_distance(starts[first], ends[first], starts[second], ends[second])
    return bool((gaps_m < TOLERANCE_M).any())
