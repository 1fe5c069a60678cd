"""Places beside vehicles that cannot be asked to make way: vehicles that hover in the column of one move out of it.

A pilot, or the failsafe of a vehicle that is not heard, may land it at any time. The vetting of paths keeps clear of
the column below the vehicle, but does not move vehicles that are in it already, or that the pilot approaches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import clearances, joint_errors_m
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.waypoints import WaypointRecord

FloatArray = NDArray[np.float64]

_TOLERATED = 0.5
"""Part of the drift by which a vehicle may be too near without moving away: it would sway to and fro at the limit."""
_TOLERATED_SHARE = 0.1
"""The same for a vehicle that does not drift, as part of the separation."""
_BEYOND_M = 0.1
"""Distance beyond the limit to which a vehicle moves."""


def evasions(
    requests: Sequence[WaypointRequest],
    records: Sequence[WaypointRecord],
    obstacles: Sequence[Obstacle],
    separation_m: float,
) -> Mapping[int, tuple[FloatArray, int]]:
    """Return where vehicles move out of the column of one that is left alone, shape (3,), and that one's id, by id.

    Only those are named whose vetted waypoints leave them in it.

    Args:
        requests: the vehicles to send.
        records: what became of their requests, in the same order.
        obstacles: all other airborne vehicles.
        separation_m: smallest true distance.
    """
    left_alone = [obstacle for obstacle in obstacles if obstacle.left_alone]
    places: dict[int, tuple[FloatArray, int]] = {}
    for request, record in zip(requests, records, strict=True):
        if record.is_unfit:
            continue
        end_enu_m = np.array(request.position_enu_m if record.sent_enu_m is None else record.sent_enu_m)
        near = [other for other in left_alone if _is_in_column(end_enu_m, other, request, separation_m)]
        if near:
            nearest = min(near, key=lambda other: float(np.linalg.norm((other.position_enu_m - end_enu_m)[:2])))
            places[request.vehicle_id] = _beside(request, nearest, separation_m), nearest.vehicle_id
    return places


def _is_in_column(place_enu_m: FloatArray, other: Obstacle, request: WaypointRequest, separation_m: float) -> bool:
    column = replace(
        other, drift_m=_TOLERATED * other.drift_m, column=True, waypoint_enu_m=None, stop_enu_m=None, home_enu_m=None
    )
    least_m = separation_m if other.drift_m else (1.0 - _TOLERATED_SHARE) * separation_m
    return column.is_near(place_enu_m, place_enu_m, request.accuracy, least_m)


def _beside(request: WaypointRequest, other: Obstacle, separation_m: float) -> FloatArray:
    """Return the place straight away from the other vehicle, at the same height, that is clear of its column."""
    _, narrow = clearances(separation_m, *np.atleast_2d(joint_errors_m(request.accuracy, other.reckoned)).T)
    for way_m in (request.position_enu_m - other.position_enu_m, request.requested_enu_m - other.position_enu_m):
        length_m = float(np.linalg.norm(way_m[:2]))
        if length_m > 0.0:
            direction = way_m[:2] / length_m
            break
    else:
        direction = np.array([1.0, 0.0])
    reach_m = float(narrow.wide_m[0]) + _BEYOND_M
    return np.array([*(other.position_enu_m[:2] + reach_m * direction), request.position_enu_m[2]])
