"""Distances between vehicles and between the straight segments that they fly.

The functions work in any dimension: with heights for separation, without them for fences. Arrays broadcast over all
axes but the last, which holds the coordinates.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TOLERANCE_M = 1e-7
"""Shortfalls below this are rounding, not conflicts."""

_RESOLUTION_M = 0.1 * TOLERANCE_M
"""Length to which bisection resolves a segment."""


def minimum_separation(positions_enu_m: FloatArray) -> tuple[float, tuple[int, int]]:
    """Return the smallest distance between two vehicles, metres, and their rows (i < j).

    Args:
        positions_enu_m: shape (n, 3), metres.

    Raises:
        ValueError: fewer than two vehicles.
    """
    positions_m = np.asarray(positions_enu_m, dtype=np.float64)
    if len(positions_m) < 2:
        raise ValueError(f"a distance needs two or more vehicles, but there are {len(positions_m)}")
    first, second = _pairs(len(positions_m))
    distances_m = np.linalg.norm(positions_m[first] - positions_m[second], axis=1)
    closest = int(distances_m.argmin())
    return float(distances_m[closest]), (int(first[closest]), int(second[closest]))


@lru_cache(maxsize=16)
def _pairs(n: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows of the first and the second vehicle of each pair; the monitor asks for them at every tick."""
    first, second = np.triu_indices(n, k=1)
    return first, second


def segment_distance(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray) -> FloatArray:
    """Return the smallest distances between segments a0-a1 and b0-b1, metres; points are segments of no length."""
    return closest_approach(a0, a1, b0, b1)[0]


def closest_approach(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest distances between segments, and where on the first ones they occur.

    The closest points are an end of one segment and a point of the other, or inner points of both; the best of these
    five candidates is robust against parallel and vanishing segments.

    Args:
        a0: starts of the first segments, shape (..., d), metres.
        a1: their ends.
        b0: starts of the second segments, shape (..., d), metres.
        b1: their ends.

    Returns:
        Distances (...), metres, and fractions (...) along a0-a1, in [0, 1].
    """
    a0, a1, b0, b1 = np.broadcast_arrays(a0, a1, b0, b1)
    from_b0_m, fraction_b0 = point_segment_distance(b0, a0, a1)
    from_b1_m, fraction_b1 = point_segment_distance(b1, a0, a1)
    inner_m, inner_fraction = _inner_approach(a0, a1, b0, b1)
    from_a0_m, zero = point_segment_distance(a0, b0, b1)[0], np.zeros_like(inner_m)
    distances_m = np.stack([from_a0_m, point_segment_distance(a1, b0, b1)[0], from_b0_m, from_b1_m, inner_m])
    fractions = np.stack([zero, zero + 1.0, fraction_b0, fraction_b1, inner_fraction])
    best = distances_m.argmin(axis=0)[None]
    return np.take_along_axis(distances_m, best, axis=0)[0], np.take_along_axis(fractions, best, axis=0)[0]


def near_pairs(
    a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray, reach_m: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows of all pairs of plane segments a0-a1 and b0-b1 that may come within reach; the others do not.

    Far cheaper than distances: it selects the pairs that need one. Two segments are apart when their bounding boxes
    are, or when one lies beside the line through the other.

    Args:
        a0: starts of the first segments, shape (n, 2), metres.
        a1: their ends.
        b0: starts of the second segments, shape (m, 2), metres.
        b1: their ends.
        reach_m: 0 or more.

    Returns:
        Rows of first and of second segments, shape (k,) each.
    """
    east = _overlap(a0[:, None, 0], a1[:, None, 0], b0[:, 0], b1[:, 0], reach_m)
    north = _overlap(a0[:, None, 1], a1[:, None, 1], b0[:, 1], b1[:, 1], reach_m)
    first, second = np.nonzero(east & north)
    near = ~_lies_beside(a0[first], a1[first], b0[second], b1[second], reach_m)
    first, second = first[near], second[near]
    near = ~_lies_beside(b0[second], b1[second], a0[first], a1[first], reach_m)
    return first[near], second[near]


def _overlap(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray, reach_m: float) -> NDArray[np.bool_]:
    """Return whether intervals, ends in any order, come within reach."""
    return np.asarray(
        (np.minimum(a0, a1) - reach_m <= np.maximum(b0, b1)) & (np.minimum(b0, b1) - reach_m <= np.maximum(a0, a1))
    )


def _lies_beside(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray, reach_m: float) -> NDArray[np.bool_]:
    """Return whether both ends of b0-b1 are beyond reach on the same side of the line through a0-a1."""
    east, north = a1[..., 0] - a0[..., 0], a1[..., 1] - a0[..., 1]
    reach = reach_m * np.hypot(east, north)
    side_0 = east * (b0[..., 1] - a0[..., 1]) - north * (b0[..., 0] - a0[..., 0])
    side_1 = east * (b1[..., 1] - a0[..., 1]) - north * (b1[..., 0] - a0[..., 0])
    return np.asarray((np.minimum(side_0, side_1) > reach) | (np.maximum(side_0, side_1) < -reach))


def point_segment_distance(point: FloatArray, b0: FloatArray, b1: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the distances of points to segments (...), metres, and the fractions (...) along b0-b1."""
    along = b1 - b0
    length2 = _dot(along, along)
    from_b0 = point - b0
    fraction = np.minimum(np.maximum(_dot(from_b0, along) / np.where(length2 > 0.0, length2, 1.0), 0.0), 1.0)
    offset = from_b0 - fraction[..., None] * along
    return np.sqrt(_dot(offset, offset)), fraction


def admissible_fraction(
    start_m: FloatArray, end_m: FloatArray, b0: FloatArray, b1: FloatArray, required_m: FloatArray
) -> FloatArray:
    """Return the fraction of the segment ``start_m`` to ``end_m`` that keeps the required distance to each other one.

    The distance to a segment is a convex function of the length flown. It falls up to the closest approach;
    bisection finds the point where it falls short.

    Args:
        start_m: shape (d,) or, one for each segment to keep away from, (m, d), metres.
        end_m: the same shape.
        b0: starts of the segments to keep away from, shape (m, d), metres.
        b1: their ends.
        required_m: shape (m,), metres; at most the distance at the start.

    Returns:
        Fractions in [0, 1], shape (m,).
    """
    closest_m, closest_fraction = closest_approach(start_m, end_m, b0, b1)
    short = closest_m < required_m - TOLERANCE_M
    fractions = np.ones_like(closest_m)
    if not short.any():
        return fractions
    start_m, end_m = (np.broadcast_to(point_m, b0.shape)[short] for point_m in (start_m, end_m))
    b0, along = b0[short], (b1 - b0)[short]
    fractions[short] = _bisect(end_m - start_m, start_m - b0, along, required_m[short], closest_fraction[short])
    return fractions


def _bisect(
    way: FloatArray, offset: FloatArray, along: FloatArray, required_m: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the largest fractions of ways, up to ``high``, that keep the required distances to other segments.

    Args:
        way: vectors from the start of a way to its end, shape (m, d), metres.
        offset: vectors from the start of the other segment to the start of the way.
        along: vectors from the start of the other segment to its end.
        required_m: shape (m,), metres; at most the distance at the start.
        high: fraction of the closest approach, shape (m,); the distance falls until there.
    """
    length2 = _dot(along, along)
    length2 = np.where(length2 > 0.0, length2, 1.0)
    # The closest point of the other segment, as a fraction of it, and how it moves with the fraction of the way.
    closest, moves = _dot(offset, along) / length2, _dot(way, along) / length2
    required2, low = required_m * required_m, np.zeros_like(high)
    longest_m = float(np.sqrt(_dot(way, way).max()))
    for _ in range(math.ceil(math.log2(max(2.0, longest_m / _RESOLUTION_M)))):
        middle = 0.5 * (low + high)
        fraction = np.minimum(np.maximum(closest + middle * moves, 0.0), 1.0)
        distance = offset + middle[:, None] * way - fraction[:, None] * along
        clear = _dot(distance, distance) >= required2
        low, high = np.where(clear, middle, low), np.where(clear, high, middle)
    return low


def _inner_approach(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distance and fraction where the common perpendicular meets both segments inside, else infinity."""
    u, v, w = a1 - a0, b1 - b0, a0 - b0
    uu, uv, vv, uw, vw = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    skew = determinant > 1e-12 * uu * vv
    divisor = np.where(skew, determinant, 1.0)
    s, t = (uv * vw - vv * uw) / divisor, (uu * vw - uv * uw) / divisor
    inside = skew & (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
    offset = w + s[..., None] * u - t[..., None] * v
    return np.where(inside, np.sqrt(_dot(offset, offset)), np.inf), np.where(inside, s, 0.0)


def _dot(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(np.vecdot(x, y))
