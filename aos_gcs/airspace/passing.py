"""Ways around vehicles that cannot be asked to make way, for vehicles whose straight ways lead through their columns.

Each of them may come down at any time, so nobody passes below; but whoever hovers for minutes, or is not heard, must
not hold up others. A vehicle that is not heard may also come down above its launch point.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import clearances, joint_errors_m
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict

FloatArray = NDArray[np.float64]

SIDES = (1.0, -1.0)
"""The shorter way around, and the other one."""
_BEYOND_M = 0.3
"""Distance beyond the limit at which a way leads around: vehicles miss its corners by their arrival radius."""
_STEP_RAD = math.radians(45.0)
"""Angle about the other vehicle from one corner to the next."""


def ways_around(
    requests: Sequence[WaypointRequest],
    records: Sequence[WaypointRecord],
    obstacles: Sequence[Obstacle],
    separation_m: float,
    side: float,
) -> Mapping[int, tuple[FloatArray, int]]:
    """Return the next corners of ways around vehicles that are left alone, shape (3,), and whose they are, by id.

    Only vehicles are named whose waypoints were not sent as asked for, and whose straight ways lead through such a
    column, but do not end in it.

    Args:
        requests: the vehicles to send.
        records: what became of their requests, in the same order.
        obstacles: all other airborne vehicles.
        separation_m: smallest true distance.
        side: one of ``SIDES``.
    """
    columns = [column for other in obstacles if other.left_alone for column in _columns(other)]
    corners: dict[int, tuple[FloatArray, int]] = {}
    for request, record in zip(requests, records, strict=True):
        if record.is_unfit or record.verdict is WaypointVerdict.SENT:
            continue
        start_m, end_m = request.position_enu_m, request.requested_enu_m
        barring = [
            column
            for column in columns
            if column.is_near(start_m, end_m, request.accuracy, separation_m)
            and not column.is_near(end_m, end_m, request.accuracy, separation_m)
        ]
        if barring:
            nearest = min(barring, key=lambda other: math.dist(other.position_enu_m[:2], start_m[:2]))
            corners[request.vehicle_id] = _corner(request, nearest, separation_m, side), nearest.vehicle_id
    return corners


def _columns(other: Obstacle) -> list[Obstacle]:
    """Return the columns in which another vehicle may come down: where it hovers, and above its launch point."""
    bare = replace(other, column=True, waypoint_enu_m=None, stop_enu_m=None, home_enu_m=None)
    # A vehicle that moves has left its column before the way around that has been flown.
    columns = [] if other.stop_enu_m is not None else [bare]
    if other.home_enu_m is not None:
        columns.append(replace(bare, position_enu_m=np.array([*other.home_enu_m[:2], other.position_enu_m[2]])))
    return columns


def _corner(request: WaypointRequest, other: Obstacle, separation_m: float, side: float) -> FloatArray:
    """Return a place at the height of the waypoint, beyond which the way around the other vehicle goes on."""
    _, narrow = clearances(separation_m, *np.atleast_2d(joint_errors_m(request.accuracy, other.reckoned)).T)
    radius_m = float(narrow.wide_m[0]) + _BEYOND_M
    from_m, to_m = (
        place_m[:2] - other.position_enu_m[:2] for place_m in (request.position_enu_m, request.requested_enu_m)
    )
    bearing_rad = math.atan2(from_m[1], from_m[0])
    turn_rad = math.remainder(math.atan2(to_m[1], to_m[0]) - bearing_rad, math.tau)
    # The tangent to the circle, and on along it to where the next tangent begins.
    along_rad = math.acos(min(1.0, radius_m / max(float(np.hypot(*from_m)), radius_m))) + _STEP_RAD / 2.0
    corner_rad = bearing_rad + side * math.copysign(along_rad, turn_rad)
    away_m = radius_m / math.cos(_STEP_RAD / 2.0) * np.array([math.cos(corner_rad), math.sin(corner_rad)])
    return np.array([*(other.position_enu_m[:2] + away_m), request.requested_enu_m[2]])
