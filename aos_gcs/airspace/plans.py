"""Vetting of planned waypoints in one situation of the traffic, with paths around what blocks the straight ones.

Where the altitude layers follow the ground, a way is flown in straight pieces that stay near its layer.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.evasion import evasions
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.passing import SIDES, ways_around
from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict, as_enu_point

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrafficSituation:
    """What the vetting of waypoints depends on besides the waypoints: plain data that can be recorded."""

    limits: SafetyLimits
    arrival_radius_m: float
    """Distance by which vehicles may miss a corner of a path around a boundary."""
    movable: tuple[WaypointRequest, ...] = ()
    """Vehicles that may be sent; each requests the place where it is."""
    left: Mapping[int, str] = field(default_factory=dict)
    """Reason why a vehicle must not be sent any more, by id."""
    obstacles: tuple[Obstacle, ...] = ()
    """All other airborne vehicles."""

    def detours(self) -> Detours:
        """Return the admissible paths within the limits."""
        return Detours(self.limits.boundaries(), self.arrival_radius_m)


def vet_plan(
    planned_enu_m: Mapping[int, FloatArray],
    situation: TrafficSituation,
    detours: Detours,
    ground: GroundRaster | None = None,
    surface: ReferenceSurface = LEVEL,
) -> tuple[WaypointRecord, ...]:
    """Check planned waypoints, shape (3,) each, against the limits, each other and all other airborne vehicles.

    Where a boundary blocks the straight path and there is a path around it, the next corner of that is granted; where
    the straight path would leave the layer of its waypoint, the first piece of it. A vehicle that would stay in the
    column of one that is left alone is sent out of it instead, and one whose way leads through it around it.

    Args:
        planned_enu_m: waypoint by vehicle id, for each vehicle of the situation that may be sent, or has left.
        situation: state of the traffic.
        detours: those of the situation.
        ground: ground that the situation's limits refer to.
        surface: surface that the altitude layers are offset from.
    """
    moving, cut = _first_legs(detours, situation.movable, planned_enu_m, surface)
    vetted = vet_waypoints(moving, situation.obstacles, situation.limits, ground)
    evading = evasions(moving, vetted, situation.obstacles, situation.limits.separation_m)
    if evading:
        moving = [
            replace(one, requested_enu_m=evading.get(one.vehicle_id, (one.requested_enu_m,))[0]) for one in moving
        ]
        cut = {
            **cut,
            **{key: f"clear of {_named(other_id, situation)}" for key, (_, other_id) in evading.items()},
        }
        vetted = vet_waypoints(moving, situation.obstacles, situation.limits, ground)
    moving, passing = _around_columns(moving, vetted, situation, evading.keys(), ground=ground, surface=surface)
    if passing:
        cut = {**cut, **passing}
        vetted = vet_waypoints(moving, situation.obstacles, situation.limits, ground)
    left = [_left(vehicle_id, planned_enu_m[vehicle_id], reason) for vehicle_id, reason in situation.left.items()]
    return (*(_as_planned(record, planned_enu_m[record.vehicle_id], cut) for record in vetted), *left)


def _around_columns(
    moving: Sequence[WaypointRequest],
    vetted: Sequence[WaypointRecord],
    situation: TrafficSituation,
    evading: Collection[int],
    *,
    ground: GroundRaster | None,
    surface: ReferenceSurface,
) -> tuple[list[WaypointRequest], dict[int, str]]:
    """Return the requests with ways around vehicles that are left alone, and why that is, by id.

    Where neither side is free, the request stays as it is: the vehicle waits.
    """
    asked, taken = list(moving), dict[int, str]()
    for side in SIDES:
        corners = ways_around(moving, vetted, situation.obstacles, situation.limits.separation_m, side)
        tried = {key: one for key, one in corners.items() if key not in evading and key not in taken}
        if not tried:
            break
        trial = [
            replace(one, requested_enu_m=_in_layer(one.requested_enu_m, tried[one.vehicle_id][0], surface))
            if one.vehicle_id in tried
            else one
            for one in asked
        ]
        for row, record in enumerate(vet_waypoints(trial, situation.obstacles, situation.limits, ground)):
            if record.vehicle_id in tried and record.verdict is WaypointVerdict.SENT:
                asked[row] = trial[row]
                taken[record.vehicle_id] = f"around {_named(tried[record.vehicle_id][1], situation)}"
    return asked, taken


def _named(vehicle_id: int, situation: TrafficSituation) -> str:
    """Return the name of an obstacle that is left alone, with what keeps it from being asked to make way."""
    (why,) = (other.left_alone for other in situation.obstacles if other.vehicle_id == vehicle_id)
    return f"vehicle {vehicle_id}, {why}"


def _in_layer(waypoint_enu_m: FloatArray, place_enu_m: FloatArray, surface: ReferenceSurface) -> FloatArray:
    """Return a place, shape (3,), as high above the surface as a waypoint."""
    return np.array([*place_enu_m[:2], waypoint_enu_m[2] - surface.at(waypoint_enu_m) + surface.at(place_enu_m)])


def reached(positions_enu_m: Sequence[FloatArray], places_m: FloatArray, detours: Detours) -> NDArray[np.bool_]:
    """Return which horizontal places, shape (k, 2), one of several vehicles can reach past the boundaries."""
    is_reached = np.zeros(len(places_m), dtype=np.bool_)
    for position_enu_m in positions_enu_m:
        if not is_reached.all():
            is_reached[~is_reached] = detours.reached(position_enu_m[:2], places_m[~is_reached])
    return is_reached


def _first_legs(
    detours: Detours,
    movable: Sequence[WaypointRequest],
    planned_enu_m: Mapping[int, FloatArray],
    surface: ReferenceSurface,
) -> tuple[list[WaypointRequest], Mapping[int, str]]:
    """Return requests for the waypoints, or for what comes first on the ways there, and why that is, by id."""
    planned = {one.vehicle_id: np.asarray(planned_enu_m[one.vehicle_id], dtype=np.float64) for one in movable}
    finite = [one for one in movable if np.isfinite(planned[one.vehicle_id]).all()]
    corners_m = detours.next_corners(
        np.array([one.position_enu_m[:2] for one in finite]).reshape(-1, 2),
        np.array([planned[one.vehicle_id][:2] for one in finite]).reshape(-1, 2),
    )
    cut = {}
    for one, corner_m in zip(finite, corners_m, strict=True):
        end_m = planned[one.vehicle_id][:2] if corner_m is None else corner_m
        share = surface.straight_share(one.position_enu_m, end_m)
        if corner_m is None and share == 1.0:
            continue
        cut[one.vehicle_id] = "along the ground" if corner_m is None else "around the geofence or a no-go zone"
        place_m = end_m if share == 1.0 else one.position_enu_m[:2] + share * (end_m - one.position_enu_m[:2])
        layer_m = planned[one.vehicle_id][2] - surface.at(planned[one.vehicle_id])
        planned[one.vehicle_id] = np.array([*place_m, layer_m + surface.at(place_m)])
    return [replace(one, requested_enu_m=planned[one.vehicle_id]) for one in movable], cut


def _as_planned(record: WaypointRecord, planned_enu_m: FloatArray, cut: Mapping[int, str]) -> WaypointRecord:
    """Return what became of the planned waypoint, where the first part of the way to it was vetted."""
    planned = as_enu_point(planned_enu_m)
    if record.requested_enu_m == planned or not np.isfinite(planned_enu_m).all():
        return record
    if record.verdict is not WaypointVerdict.SENT:
        return replace(record, requested_enu_m=planned)
    east_m, north_m, _ = record.requested_enu_m
    reason = f"{cut[record.vehicle_id]}, by {east_m:.0f} m east, {north_m:.0f} m north"
    return replace(record, requested_enu_m=planned, verdict=WaypointVerdict.SHORTENED, reason=reason)


def _left(vehicle_id: int, planned_enu_m: FloatArray, reason: str) -> WaypointRecord:
    return WaypointRecord(vehicle_id, as_enu_point(planned_enu_m), None, WaypointVerdict.HELD, reason, True)
