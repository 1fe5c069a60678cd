"""Turns in flight: where a vehicle comes to while it still moves as before, on its way to another waypoint.

Waypoints are vetted along straight segments, but a vehicle that is fast flies on for its stopping distance while it
turns, and then straight to the waypoint from there: past the corner of a zone that both segments keep clear of.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Boundary, contains, edges
from aos_gcs.airspace.separation import segment_distance

FloatArray = NDArray[np.float64]

SLACK_M = 0.5
"""Distance by which a turn may come nearer to a boundary than straight flight: velocities are noisy, and gusts pass."""
_LEAST_M = 1e-6
"""Distance that every turn keeps, so that rounding does not carry it across a boundary without a margin."""


def boundary_met(
    start_m: FloatArray,
    stop_m: FloatArray,
    end_m: FloatArray,
    boundaries: tuple[Boundary, ...],
    former_end_m: FloatArray | None = None,
) -> Boundary | None:
    """Return the first boundary whose margin a vehicle may enter while it turns; None if it keeps all of them.

    A vehicle whose way within a margin is decided already may turn, but not so that it comes farther into it.

    Args:
        start_m: where it is, shape (2,).
        stop_m: where it would come to a stop if it were told to now, shape (2,).
        end_m: waypoint that it is sent to, shape (2,).
        boundaries: the geofence and the no-go zones.
        former_end_m: waypoint that it flies to now, shape (2,), in front of which it brakes; None: it has none.
    """
    straight_on_m = stop_m if former_end_m is None else former_end_m
    if math.dist(straight_on_m, end_m) <= SLACK_M:
        return None
    swept_m = _swept(start_m, stop_m, end_m)
    return next((one for one in boundaries if _enters(swept_m, start_m, straight_on_m, one)), None)


def _swept(start_m: FloatArray, stop_m: FloatArray, end_m: FloatArray) -> FloatArray:
    """Return the corners, shape (4, 2), of the ground above which a vehicle turns.

    Along its motion it comes as far as it brakes, or as the waypoint; beside it, as far as the waypoint.
    """
    braking_m = stop_m - start_m
    along = braking_m / max(float(np.hypot(*braking_m)), _LEAST_M)
    past_m = max(0.0, float((stop_m - end_m) @ along))
    return np.array([start_m, stop_m, end_m + past_m * along, end_m])


def _enters(swept_m: FloatArray, start_m: FloatArray, straight_on_m: FloatArray, boundary: Boundary) -> bool:
    starts, ends = edges(boundary.vertices_m)
    straight_m = float(segment_distance(start_m, straight_on_m, starts, ends).min())
    depth_m = boundary.depth_m(start_m)
    if depth_m <= _LEAST_M or straight_m <= _LEAST_M:  # on the wrong side, or about to be: no turn is worse
        return False
    required_m = max(min(boundary.margin_m, straight_m) - SLACK_M, _LEAST_M)
    sides_m = segment_distance(swept_m[:, None], np.roll(swept_m, -1, axis=0)[:, None], starts, ends)
    return bool(sides_m.min() < required_m) or any(contains(vertex_m, swept_m) for vertex_m in starts)
