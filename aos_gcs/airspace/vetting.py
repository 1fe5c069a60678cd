"""Vetting of waypoints: each planned waypoint is sent, shortened or held, never sent unchecked.

A vehicle flies the straight segment from where it is to its waypoint. One that is too fast for that, so that its turn
would enter the margin of a boundary, is held until it is slow enough, or flies on to where it brakes already. Two rules
keep the checks consistent:

- Vehicles are vetted by ascending id. A segment keeps its distance to the segments admitted before, and to where all
  other vehicles are now, go on to, and would come to a stop, so that holding stays safe for vehicles that are vetted
  later. The order of the arguments changes nothing.
- A vehicle that violates a limit already may move, but not so that it violates it more.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.above_ground import above_ground
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.polygon import Boundary, edges, edges_met
from aos_gcs.airspace.separation import admissible_fraction
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.airspace.traffic import ALL_ADMITTED, MIN_MOVE_M, Admission, Obstacle, Traffic, WaypointRequest
from aos_gcs.airspace.turning import SLACK_M, boundary_met
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict, as_enu_point

FloatArray = NDArray[np.float64]

BACK_OFF_M = 1e-6
"""Distance by which a shortened segment ends before the limit, so that rounding does not carry it across."""


def vet_waypoints(
    requests: Sequence[WaypointRequest],
    obstacles: Sequence[Obstacle],
    limits: SafetyLimits,
    ground: GroundRaster | None = None,
) -> tuple[WaypointRecord, ...]:
    """Return what becomes of each requested waypoint, in the order of ``requests``.

    A waypoint whose whole segment is admissible is sent as it is; otherwise the largest admissible part of the segment
    is flown; a vehicle that must not or cannot move is held. The result does not depend on the order of the arguments.

    Args:
        requests: the vehicles to send, with distinct ids and finite positions.
        obstacles: all other airborne vehicles.
        limits: geofence, no-go zones, heights, separation, ages and battery.
        ground: ground that the limits above it refer to.

    Raises:
        ValueError: an id occurs twice, or a present position is not finite.
    """
    traffic = Traffic(requests, obstacles, limits.separation_m)
    boundaries = limits.boundaries()
    reasons = {request.vehicle_id: _reason_to_hold(request, limits) for request in requests}
    moving = [request for request in requests if not reasons[request.vehicle_id]]
    far = _far(moving, boundaries, traffic)
    ground_met = above_ground(moving, limits.above_ground, ground)
    records = {}
    for request in sorted(requests, key=lambda request: request.vehicle_id):
        if reason := reasons[request.vehicle_id]:
            record = replace(_held(request, reason), is_unfit=True)
        else:
            at_ground = ground_met.get(request.vehicle_id, ALL_ADMITTED)
            record = _vet_segment(request, boundaries, traffic, limits, (far, at_ground))
            if record.sent_enu_m is not None:
                traffic.admit(request.vehicle_id, np.array(record.sent_enu_m))
        records[request.vehicle_id] = record
    return tuple(records[request.vehicle_id] for request in requests)


@dataclass(frozen=True, slots=True)
class _Far:
    """Vehicles, by id, whose segments are far from what could limit them, whatever becomes of the others."""

    boundaries: frozenset[int]
    """Vehicles that keep clear of every boundary."""
    traffic: frozenset[int]
    """Vehicles that keep clear of all others."""


def _far(moving: Sequence[WaypointRequest], boundaries: Sequence[Boundary], traffic: Traffic) -> _Far:
    """Return the vehicles that need no closer look; it is computed for all at once, in a fraction of the time."""
    if not moving:
        return _Far(frozenset(), frozenset())
    starts_enu_m = np.array([request.position_enu_m for request in moving], dtype=np.float64)
    ends_enu_m = np.array([request.requested_enu_m for request in moving], dtype=np.float64)
    stops_enu_m = np.array([one.position_enu_m if one.stop_enu_m is None else one.stop_enu_m for one in moving])
    lengths_m = np.hypot(*(ends_enu_m - starts_enu_m)[:, :2].T) + np.hypot(*(stops_enu_m - starts_enu_m)[:, :2].T)
    from_edges = np.ones(len(moving), dtype=np.bool_)
    for boundary in boundaries:
        from_edges &= boundary.depths_m(starts_enu_m[:, :2]) - lengths_m > max(boundary.margin_m, BACK_OFF_M)
    ids = [request.vehicle_id for request in moving]
    from_others = traffic.far(ids, starts_enu_m, ends_enu_m)
    return _Far(*(frozenset(itertools.compress(ids, found)) for found in (from_edges, from_others)))


def _vet_segment(
    request: WaypointRequest,
    boundaries: tuple[Boundary, ...],
    traffic: Traffic,
    limits: SafetyLimits,
    looked_at: tuple[_Far, Admission],
) -> WaypointRecord:
    """Return what becomes of a segment, after the looks at all together: what is far, and the part above ground."""
    far, at_ground = looked_at
    start = np.array(request.position_enu_m, dtype=np.float64)
    end = np.array(request.requested_enu_m, dtype=np.float64)
    admissions = [at_ground, _within_heights(float(start[2]), float(end[2]), limits)]
    if request.vehicle_id not in far.boundaries:
        admissions[:0] = [_within_boundary(start[:2], end[:2], boundary) for boundary in boundaries]
    if request.vehicle_id not in far.traffic:
        admissions.append(traffic.admissible(request.vehicle_id, start, end))
    admission = min(admissions, key=lambda admission: admission.fraction)
    sent, verdict, reason = end, WaypointVerdict.SENT, ""
    if admission.fraction < 1.0:
        length_m = float(np.linalg.norm(end - start))
        flown_m = admission.fraction * length_m - BACK_OFF_M
        if flown_m < MIN_MOVE_M:
            return _held(request, admission.reason)
        sent, verdict = start + flown_m / length_m * (end - start), WaypointVerdict.SHORTENED
        reason = f"shortened to {flown_m:.1f} of {length_m:.1f} m: {admission.reason}"
    if request.vehicle_id not in far.boundaries and request.stop_enu_m is not None:
        former = None if request.waypoint_enu_m is None else request.waypoint_enu_m[:2]
        met = boundary_met(start[:2], request.stop_enu_m[:2], sent[:2], boundaries, former)
        if met is not None:
            reason = f"it is too fast to turn there clear of {met.name}"
            return _straight_on(request, boundaries, traffic, limits, reason)
    return WaypointRecord(request.vehicle_id, as_enu_point(end), as_enu_point(sent), verdict, reason)


def _straight_on(
    request: WaypointRequest, boundaries: tuple[Boundary, ...], traffic: Traffic, limits: SafetyLimits, reason: str
) -> WaypointRecord:
    """Return what becomes of a vehicle that is too fast to turn.

    One that brakes already in front of its former waypoint flies on there: it would stop behind it if it were held.
    """
    record = _held(request, reason)
    former, stop = request.waypoint_enu_m, request.stop_enu_m
    if former is not None and stop is not None:
        start = request.position_enu_m
        if math.dist(start, former) <= math.dist(start, stop) + SLACK_M:
            on = replace(request, requested_enu_m=former, stop_enu_m=None)
            found = _vet_segment(on, boundaries, traffic, limits, (_Far(frozenset(), frozenset()), ALL_ADMITTED))
            if found.sent_enu_m is not None:
                reason = f"flies on to its former waypoint: {reason}"
                record = replace(record, sent_enu_m=found.sent_enu_m, verdict=WaypointVerdict.SHORTENED, reason=reason)
    return replace(record, is_unfit=True)


def _reason_to_hold(request: WaypointRequest, limits: SafetyLimits) -> str:  # noqa: PLR0911 - one line per reason
    """Return why the vehicle must not be sent anywhere, or nothing."""
    if not np.isfinite(request.requested_enu_m).all():
        return "the requested position is not finite"
    if request.link_age_s is None or request.position_age_s is None:
        return "it has never been heard" if request.link_age_s is None else "it has never reported a position"
    if request.link_age_s > limits.max_link_age_s:
        return f"no message for {request.link_age_s:.1f} s, limit {limits.max_link_age_s:.1f} s"
    if request.position_age_s > limits.max_position_age_s:
        return f"no position for {request.position_age_s:.1f} s, limit {limits.max_position_age_s:.1f} s"
    if request.battery_fraction is None:
        return ""
    if request.battery_fraction < limits.min_battery_fraction:
        return f"battery at {request.battery_fraction:.0%}, limit {limits.min_battery_fraction:.0%}"
    battery_per_m = limits.battery_per_m if request.battery_per_m is None else request.battery_per_m
    if battery_per_m is None:
        return ""
    if request.home_enu_m is None:
        return "its home is unknown, so the energy to return is too"
    length_m = math.dist(request.position_enu_m, request.requested_enu_m) + math.dist(
        request.requested_enu_m, request.home_enu_m
    )
    needed = limits.min_battery_fraction + battery_per_m * length_m
    if request.battery_fraction < needed:
        return f"battery at {request.battery_fraction:.0%}, but {needed:.0%} are needed to go there and return home"
    return ""


def _within_boundary(start: FloatArray, end: FloatArray, boundary: Boundary) -> Admission:
    margin_m = boundary.margin_m
    depth_m = boundary.depth_m(start)
    if depth_m <= BACK_OFF_M:
        returns = boundary.depth_m(end) >= margin_m and edges_met(start, end, boundary.vertices_m) <= 1
        return ALL_ADMITTED if returns else Admission(0.0, boundary.trespass)
    if depth_m - float(np.linalg.norm(end - start)) > max(margin_m, BACK_OFF_M):
        return ALL_ADMITTED
    # Even without a margin a segment ends just before the boundary, else it could cross it.
    required_m = max(min(margin_m, depth_m), BACK_OFF_M)
    edge_starts, edge_ends = edges(boundary.vertices_m)
    required = np.full(len(edge_starts), required_m)
    fraction = float(admissible_fraction(start, end, edge_starts, edge_ends, required).min())
    return Admission(fraction, f"{boundary.name}, with a margin of {margin_m:.1f} m")


def _within_heights(start_m: float, end_m: float, limits: SafetyLimits) -> Admission:
    lowest_m, highest_m = min(limits.floor_m, start_m), max(limits.ceiling_m, start_m)
    if end_m < lowest_m:
        return Admission((start_m - lowest_m) / (start_m - end_m), f"the floor at {limits.floor_m:.1f} m")
    if end_m > highest_m:
        return Admission((highest_m - start_m) / (end_m - start_m), f"the ceiling at {limits.ceiling_m:.1f} m")
    return ALL_ADMITTED


def _held(request: WaypointRequest, reason: str) -> WaypointRecord:
    return WaypointRecord(
        request.vehicle_id, as_enu_point(request.requested_enu_m), None, WaypointVerdict.HELD, f"held: {reason}"
    )
