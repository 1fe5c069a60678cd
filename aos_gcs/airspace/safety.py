"""Safety before every goto: each planned waypoint is sent, shortened or held, never sent unchecked.

A way is the straight segment from where a vehicle is to where it is sent. Two rules keep the checks consistent:

- Vehicles are vetted by ascending id. A way keeps its distance to the ways already granted, and to where all the others
  are now, so that holding stays safe for everyone who comes later. The order of the arguments changes nothing.
- A vehicle that violates a limit already may move, but not so that it violates it more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Boundary, Polygon, as_polygon, edges, edges_met
from aos_gcs.airspace.separation import TOLERANCE_M, admissible_fraction, point_segment_distance, segment_distance
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import EnuPoint

FloatArray = NDArray[np.float64]

BACK_OFF_M = 1e-6
"""By which a shortened way ends before the limit, so that rounding does not carry it across."""

MIN_MOVE_M = 0.1
"""Shortened ways below this are not worth a command."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SafetyLimits:
    """What waypoints must respect. Heights are metres above the mission's origin."""

    fence_enu_m: Polygon
    """Simple polygon, convex or not."""
    floor_m: float
    ceiling_m: float
    no_go_enu_m: tuple[Polygon, ...] = ()
    """Simple polygons, convex or not, in which no waypoint lies and which no way crosses, at any height."""
    margin_m: float = 0.0
    """Distance to keep from the fence on the inside and from no-go zones on the outside; the breaking distance
    v^2 / 2a is a good choice."""
    separation_m: float = 1.5
    """Smallest 3-D distance between two ways; below the spacing of the altitude layers by what heights err."""
    hold_horizontal_m: float = 1.0
    """Two vehicles measured nearer than this beside each other ..."""
    hold_vertical_m: float = 1.0
    """... and nearer than this above each other are too close: one is held. Both lie within ``separation_m``."""
    max_link_age_s: float = 3.0
    max_position_age_s: float = 3.0
    min_battery_fraction: float = 0.2
    battery_per_m: float | None = None
    """Battery fraction that a metre of flight costs; when given, the way to the waypoint and straight home must leave
    ``min_battery_fraction``."""

    def __post_init__(self) -> None:
        self.boundaries()
        positive = ("separation_m", "hold_horizontal_m", "hold_vertical_m", "max_link_age_s", "max_position_age_s")
        for name in (*positive, "margin_m", "floor_m", "ceiling_m", "min_battery_fraction", "battery_per_m"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise ConfigurationError(f"{name} must be a finite number, but is {value}.")
            if name in positive and value <= 0.0:
                raise ConfigurationError(f"{name} must be above 0, but is {value:g}.")
        if math.hypot(self.hold_horizontal_m, self.hold_vertical_m) > self.separation_m:
            raise ConfigurationError(
                f"hold_horizontal_m ({self.hold_horizontal_m:g}) and hold_vertical_m ({self.hold_vertical_m:g}) must "
                f"lie within separation_m ({self.separation_m:g}), else granted ways end in a hold; lower them."
            )
        if self.floor_m >= self.ceiling_m:
            raise ConfigurationError(f"floor_m ({self.floor_m:g}) must be below ceiling_m ({self.ceiling_m:g}).")
        if self.margin_m < 0.0:
            raise ConfigurationError(f"margin_m must not be negative, but is {self.margin_m:g}.")
        if not 0.0 <= self.min_battery_fraction < 1.0:
            raise ConfigurationError(
                f"min_battery_fraction must be 0 or more and below 1, but is {self.min_battery_fraction:g}."
            )
        if self.battery_per_m is not None and self.battery_per_m <= 0.0:
            raise ConfigurationError(f"battery_per_m must be above 0 or absent, but is {self.battery_per_m:g}.")

    def boundaries(self) -> tuple[Boundary, ...]:
        """Return what ways must not cross: the fence, and every no-go zone."""
        zones = [
            Boundary(as_polygon(zone, f"no_go_enu_m[{row}]"), f"no-go area {row + 1}", keeps_in=False)
            for row, zone in enumerate(self.no_go_enu_m)
        ]
        return (Boundary(as_polygon(self.fence_enu_m, "fence_enu_m"), "the fence", keeps_in=True), *zones)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mover:
    """A vehicle that is to be sent somewhere."""

    vehicle_id: int
    position_enu_m: FloatArray
    """Shape (3,)."""
    requested_enu_m: FloatArray
    """Shape (3,)."""
    link_age_s: float | None
    """Seconds since its last message; None if never heard."""
    position_age_s: float | None
    """Seconds since its last position; None if it never reported one."""
    battery_fraction: float | None
    """None skips the check: for a vehicle on its way home, which a low battery must not keep in the air. That a vehicle
    reports its battery at all is for preflight to see to."""
    home_enu_m: FloatArray | None = None
    """Shape (3,); needed when the energy to return is limited."""
    battery_per_m: float | None = None
    """Battery fraction that a metre of its flight costs, as measured; None leaves it to the limits."""


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """Another airborne vehicle."""

    vehicle_id: int
    position_enu_m: FloatArray
    """Shape (3,)."""
    waypoint_enu_m: FloatArray | None = None
    """Where it was sent, shape (3,): the way there is taken too."""
    column: bool = False
    """It returns, lands or climbs: everything between the ground and ``top_m`` is taken."""
    top_m: float | None = None
    """Height to which a climbing one will get, above the origin; by default where it is."""
    home_enu_m: FloatArray | None = None
    """Launch point, shape (3,), that it flies to by itself: its way there and the column above it are taken too."""

    def segments(self) -> FloatArray:
        """Return the segments on which the vehicle may be, shape (k, 2, 3)."""
        here = np.array(self.position_enu_m, dtype=np.float64)
        segments = [_column(here, self.top_m) if self.column else np.array([here, here])]
        if self.waypoint_enu_m is not None:
            segments.append(np.array([here, self.waypoint_enu_m]))
        if self.home_enu_m is not None:
            above_home = np.array([*self.home_enu_m[:2], here[2]])
            segments += [np.array([here, above_home]), _column(above_home, self.top_m)]
        return np.array(segments)


def _column(position_enu_m: FloatArray, top_m: float | None) -> FloatArray:
    low, high = position_enu_m.copy(), position_enu_m.copy()
    low[2] = min(0.0, low[2])
    high[2] = max(high[2], high[2] if top_m is None else top_m)
    return np.array([low, high])


@dataclass(frozen=True, slots=True)
class _Cut:
    """How much of a way one limit admits, and why not more."""

    fraction: float
    reason: str


_UNCUT = _Cut(1.0, "")


def vet_waypoints(
    movers: Sequence[Mover], obstacles: Sequence[Obstacle], limits: SafetyLimits
) -> tuple[WaypointRecord, ...]:
    """Return what becomes of each requested waypoint, in the order of ``movers``.

    A waypoint whose whole way is admissible is sent as it is; else the largest admissible part of the way is; a vehicle
    that must not or cannot move is held. The result does not depend on the order of the arguments.

    Args:
        movers: the vehicles to send, with distinct ids and finite positions.
        obstacles: all other airborne vehicles.
        limits: fence, no-go zones, heights, separation, ages and battery.

    Raises:
        ValueError: an id occurs twice, or a present position is not finite.
    """
    traffic = _Traffic(movers, obstacles, limits.separation_m)
    boundaries = limits.boundaries()
    records = {}
    for mover in sorted(movers, key=lambda mover: mover.vehicle_id):
        reason = _reason_to_hold(mover, limits)
        if reason:
            record = _held(mover, reason)
        else:
            record = _vet_way(mover, boundaries, traffic, limits)
            if record.sent_enu_m is not None:
                traffic.grant(mover.vehicle_id, np.array(record.sent_enu_m))
        records[mover.vehicle_id] = record
    return tuple(records[mover.vehicle_id] for mover in movers)


class _Traffic:
    """Where everyone in the air may be: points for who stays, ways for who flies home or was granted one."""

    def __init__(self, movers: Sequence[Mover], obstacles: Sequence[Obstacle], separation_m: float) -> None:
        segments = {mover.vehicle_id: np.array([[mover.position_enu_m] * 2]) for mover in movers}
        segments |= {obstacle.vehicle_id: obstacle.segments() for obstacle in obstacles}
        if len(segments) < len(movers) + len(obstacles):
            raise ValueError("each vehicle may occur once, as mover or as obstacle")
        self._ids = [vehicle_id for vehicle_id in sorted(segments) for _ in segments[vehicle_id]]
        ordered = [segments[vehicle_id] for vehicle_id in sorted(segments)]
        ends = np.concatenate(ordered, dtype=np.float64) if ordered else np.empty((0, 2, 3))
        if not np.isfinite(ends).all():
            raise ValueError("present positions must be finite; leave out a vehicle whose position is unknown")
        self._starts, self._ends = ends[:, 0].copy(), ends[:, 1].copy()
        self._separation_m = separation_m

    def grant(self, vehicle_id: int, end: FloatArray) -> None:
        """Note that a vehicle was sent to ``end``, shape (3,)."""
        self._ends[self._ids.index(vehicle_id)] = end

    def cut(self, vehicle_id: int, start: FloatArray, end: FloatArray) -> _Cut:
        """Cut a vehicle's way, ends of shape (3,), where it comes too close to another's."""
        way_m = float(np.linalg.norm(end - start))
        reach_m = way_m + np.linalg.norm(self._ends - self._starts, axis=1) + self._separation_m
        near = np.linalg.norm(self._starts - start, axis=1) <= reach_m
        near[self._ids.index(vehicle_id)] = False
        rows = np.flatnonzero(near)
        if len(rows) == 0 or way_m == 0.0:
            return _UNCUT
        starts, ends = self._starts[rows], self._ends[rows]
        now_m = point_segment_distance(start, starts, ends)[0]
        fractions = admissible_fraction(start, end, starts, ends, np.minimum(self._separation_m, now_m))
        too_close = now_m < self._separation_m - 2.0 * TOLERANCE_M
        # The distance is convex along the way, so where it grows at first it grows to the end.
        after_first_move = start + min(1.0, MIN_MOVE_M / way_m) * (end - start)
        receding = point_segment_distance(after_first_move, starts, ends)[0] > now_m + TOLERANCE_M
        fractions[too_close & ~receding] = 0.0
        worst = int(fractions.argmin())
        if fractions[worst] == 1.0:
            return _UNCUT
        passing_m = float(segment_distance(start, end, starts[worst], ends[worst]))
        other_id = self._ids[rows[worst]]
        return _Cut(
            float(fractions[worst]),
            f"it would pass vehicle {other_id} at {passing_m:.1f} m, limit {self._separation_m:.1f} m",
        )


def _vet_way(mover: Mover, boundaries: Sequence[Boundary], traffic: _Traffic, limits: SafetyLimits) -> WaypointRecord:
    start = np.array(mover.position_enu_m, dtype=np.float64)
    end = np.array(mover.requested_enu_m, dtype=np.float64)
    cut = min(
        *(_boundary_cut(start[:2], end[:2], boundary, limits.margin_m) for boundary in boundaries),
        _height_cut(float(start[2]), float(end[2]), limits),
        traffic.cut(mover.vehicle_id, start, end),
        key=lambda cut: cut.fraction,
    )
    if cut.fraction >= 1.0:
        return WaypointRecord(mover.vehicle_id, as_enu_point(end), as_enu_point(end), WaypointVerdict.SENT, "")
    way_m = float(np.linalg.norm(end - start))
    flown_m = cut.fraction * way_m - BACK_OFF_M
    if flown_m < MIN_MOVE_M:
        return _held(mover, cut.reason)
    sent = as_enu_point(start + flown_m / way_m * (end - start))
    reason = f"shortened to {flown_m:.1f} of {way_m:.1f} m: {cut.reason}"
    return WaypointRecord(mover.vehicle_id, as_enu_point(end), sent, WaypointVerdict.SHORTENED, reason)


def _reason_to_hold(mover: Mover, limits: SafetyLimits) -> str:  # noqa: PLR0911 - one line per reason
    """Return why the vehicle must not be sent anywhere, or nothing."""
    if not np.isfinite(mover.requested_enu_m).all():
        return "the requested position is not finite"
    if mover.link_age_s is None or mover.position_age_s is None:
        return "it has never been heard" if mover.link_age_s is None else "it has never reported a position"
    if mover.link_age_s > limits.max_link_age_s:
        return f"no message for {mover.link_age_s:.1f} s, limit {limits.max_link_age_s:.1f} s"
    if mover.position_age_s > limits.max_position_age_s:
        return f"no position for {mover.position_age_s:.1f} s, limit {limits.max_position_age_s:.1f} s"
    if mover.battery_fraction is None:
        return ""
    if mover.battery_fraction < limits.min_battery_fraction:
        return f"battery at {mover.battery_fraction:.0%}, limit {limits.min_battery_fraction:.0%}"
    battery_per_m = limits.battery_per_m if mover.battery_per_m is None else mover.battery_per_m
    if battery_per_m is None:
        return ""
    if mover.home_enu_m is None:
        return "its home is unknown, so the energy to return is too"
    way_m = math.dist(mover.position_enu_m, mover.requested_enu_m) + math.dist(mover.requested_enu_m, mover.home_enu_m)
    needed = limits.min_battery_fraction + battery_per_m * way_m
    if mover.battery_fraction < needed:
        return f"battery at {mover.battery_fraction:.0%}, but {needed:.0%} are needed to go there and return home"
    return ""


def _boundary_cut(start: FloatArray, end: FloatArray, boundary: Boundary, margin_m: float) -> _Cut:
    depth_m = boundary.depth_m(start)
    if depth_m <= BACK_OFF_M:
        returns = boundary.depth_m(end) >= margin_m and edges_met(start, end, boundary.vertices_m) <= 1
        return _UNCUT if returns else _Cut(0.0, boundary.trespass)
    if depth_m - float(np.linalg.norm(end - start)) > max(margin_m, BACK_OFF_M):
        return _UNCUT
    # A way keeps off the boundary by a hair even without a margin, else it could cross it.
    required_m = max(min(margin_m, depth_m), BACK_OFF_M)
    edge_starts, edge_ends = edges(boundary.vertices_m)
    required = np.full(len(edge_starts), required_m)
    fraction = float(admissible_fraction(start, end, edge_starts, edge_ends, required).min())
    return _Cut(fraction, f"{boundary.name}, with a margin of {margin_m:.1f} m")


def _height_cut(start_m: float, end_m: float, limits: SafetyLimits) -> _Cut:
    lowest_m, highest_m = min(limits.floor_m, start_m), max(limits.ceiling_m, start_m)
    if end_m < lowest_m:
        return _Cut((start_m - lowest_m) / (start_m - end_m), f"the floor at {limits.floor_m:.1f} m")
    if end_m > highest_m:
        return _Cut((highest_m - start_m) / (end_m - start_m), f"the ceiling at {limits.ceiling_m:.1f} m")
    return _UNCUT


def _held(mover: Mover, reason: str) -> WaypointRecord:
    return WaypointRecord(
        mover.vehicle_id, as_enu_point(mover.requested_enu_m), None, WaypointVerdict.HELD, f"held: {reason}"
    )


def as_enu_point(position_enu_m: FloatArray) -> EnuPoint:
    """Return plain floats for a position, shape (3,)."""
    east_m, north_m, up_m = (float(value) for value in position_enu_m)
    return east_m, north_m, up_m
