"""Ways around vehicles that hover with a pilot, for vehicles whose straight ways lead through the columns below them.

A pilot may land at any time, so nobody passes above or below; but whoever hovers for minutes must not hold up others.
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
    """Return the next corners of ways around vehicles that hover with a pilot, shape (3,), and whose they are, by id.

    Only vehicles are named whose waypoints were not sent as asked for, and whose straight ways lead through such a
    column, but neither begin nor end in it.

    Args:
        requests: the vehicles to send.
        records: what became of their requests, in the same order.
        obstacles: all other airborne vehicles.
        separation_m: smallest true distance.
        side: one of ``SIDES``.
    """
    hovering = [other for other in obstacles if other.drift_m > 0.0 and other.stop_enu_m is None]
    corners: dict[int, tuple[FloatArray, int]] = {}
    for request, record in zip(requests, records, strict=True):
        if record.is_unfit or record.verdict is WaypointVerdict.SENT:
            continue
        start_m, end_m = request.position_enu_m, request.requested_enu_m
        barring = [
            other
            for other in hovering
            if _meets(start_m, end_m, other, request, separation_m)
            and not _meets(start_m, start_m, other, request, separation_m)
            and not _meets(end_m, end_m, other, request, separation_m)
        ]
        if barring:
            nearest = min(barring, key=lambda other: math.dist(other.position_enu_m[:2], start_m[:2]))
            corners[request.vehicle_id] = _corner(request, nearest, separation_m, side), nearest.vehicle_id
    return corners


def _meets(
    start_m: FloatArray, end_m: FloatArray, other: Obstacle, request: WaypointRequest, separation_m: float
) -> bool:
    """Return whether a way leads through all that another vehicle occupies where it hovers."""
    column = replace(other, column=True, waypoint_enu_m=None, home_enu_m=None)
    return column.is_near(start_m, end_m, request.accuracy, separation_m)


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
