"""Safety limits of a flight, and the values that a configuration, a plan or a script sets for them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import lru_cache

from aos_gcs.airspace.polygon import Boundary, Polygon, as_polygon
from aos_gcs.errors import ConfigurationError

MIN_LAUNCH_DISTANCE_M = 2.0
"""Smallest distance between two launch points, whatever ``separation_m`` is: vehicles climb side by side, and the
positions of both err."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundLimits:
    """Heights above the ground that vehicles keep, and how the ground lies in the mission's frame."""

    floor_m: float
    ceiling_m: float
    offsets_m: tuple[float, float]
    """What launch points add to the lowest and to the highest ground of the elevation model."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SafetyLimits:
    """Limits that every waypoint must respect. Heights are metres above the mission's origin."""

    fence_enu_m: Polygon
    """Geofence, a simple polygon, convex or not."""
    floor_m: float
    ceiling_m: float
    no_go_enu_m: tuple[Polygon, ...] = ()
    """No-go zones, simple polygons, convex or not: no waypoint lies inside and no segment crosses, at any height."""
    margin_m: float = 0.0
    """Distance to keep from the geofence on the inside."""
    no_go_margin_m: float | None = None
    """Distance to keep from no-go zones on the outside; None: ``margin_m``."""
    separation_m: float = 1.5
    """Smallest 3-D distance between the segments of two vehicles. It must stay below the spacing of the altitude layers
    by what heights err, else vehicles in neighbouring layers block each other."""
    hold_horizontal_m: float = 1.0
    """Horizontal distance of two vehicles below which one is held, if ``hold_vertical_m`` is violated, too. Both lie
    within ``separation_m``."""
    hold_vertical_m: float = 1.0
    """Vertical distance that belongs to ``hold_horizontal_m``."""
    max_link_age_s: float = 3.0
    max_position_age_s: float = 3.0
    min_battery_fraction: float = 0.2
    battery_per_m: float | None = None
    """Battery fraction that a metre of flight costs; when given, the flight to the waypoint and straight home must
    leave ``min_battery_fraction``."""
    above_ground: GroundLimits | None = None
    """Limits above the ground; None: the ground counts as level."""

    def __post_init__(self) -> None:
        self.boundaries()
        positive = ("separation_m", "hold_horizontal_m", "hold_vertical_m", "max_link_age_s", "max_position_age_s")
        others = ("margin_m", "no_go_margin_m", "floor_m", "ceiling_m", "min_battery_fraction", "battery_per_m")
        for name in (*positive, *others):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise ConfigurationError(f"{name} must be a finite number, but is {value}.")
            if name in positive and value <= 0.0:
                raise ConfigurationError(f"{name} must be above 0, but is {value:g}.")
            if name.endswith("margin_m") and value is not None and value < 0.0:
                raise ConfigurationError(f"{name} must not be negative, but is {value:g}.")
        if math.hypot(self.hold_horizontal_m, self.hold_vertical_m) > self.separation_m:
            raise ConfigurationError(
                f"hold_horizontal_m ({self.hold_horizontal_m:g}) and hold_vertical_m ({self.hold_vertical_m:g}) must "
                f"lie within separation_m ({self.separation_m:g}), else vehicles on vetted segments are held; lower "
                "them."
            )
        if self.floor_m >= self.ceiling_m:
            raise ConfigurationError(f"floor_m ({self.floor_m:g}) must be below ceiling_m ({self.ceiling_m:g}).")
        if not 0.0 <= self.min_battery_fraction < 1.0:
            raise ConfigurationError(
                f"min_battery_fraction must be 0 or more and below 1, but is {self.min_battery_fraction:g}."
            )
        if self.battery_per_m is not None and self.battery_per_m <= 0.0:
            raise ConfigurationError(f"battery_per_m must be above 0 or absent, but is {self.battery_per_m:g}.")

    @property
    def launch_distance_m(self) -> float:
        """Smallest horizontal distance between two launch points."""
        return max(self.separation_m, MIN_LAUNCH_DISTANCE_M)

    def boundaries(self) -> tuple[Boundary, ...]:
        """Return what no segment may cross: the geofence, and every no-go zone."""
        no_go_margin_m = self.margin_m if self.no_go_margin_m is None else self.no_go_margin_m
        asked = self.fence_enu_m, self.margin_m, self.no_go_enu_m, no_go_margin_m
        try:
            return _boundaries(*asked)
        except TypeError:  # lists and arrays have no hash to keep boundaries by
            return _boundaries.__wrapped__(*asked)


@lru_cache(maxsize=64)
def _boundaries(
    fence_enu_m: Polygon, margin_m: float, no_go_enu_m: tuple[Polygon, ...], no_go_margin_m: float
) -> tuple[Boundary, ...]:
    """Return the checked boundaries of limits; every vetting of waypoints asks for them again."""
    fence_m = as_polygon(fence_enu_m, "fence_enu_m")
    zones_m = [as_polygon(zone, f"no_go_enu_m[{row}]") for row, zone in enumerate(no_go_enu_m)]
    for vertices_m in (fence_m, *zones_m):
        vertices_m.flags.writeable = False
    zones = [
        Boundary(vertices_m, f"no-go zone {row}", keeps_in=False, margin_m=no_go_margin_m)
        for row, vertices_m in enumerate(zones_m, start=1)
    ]
    return (Boundary(fence_m, "the geofence", keeps_in=True, margin_m=margin_m), *zones)


_FAR_M = 1e5
UNLIMITED = SafetyLimits(
    fence_enu_m=((-_FAR_M, -_FAR_M), (_FAR_M, -_FAR_M), (0.0, _FAR_M)), floor_m=-_FAR_M, ceiling_m=_FAR_M
)
"""Limits with every default, and a geofence and heights that no flight reaches: a base to check values against."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SafetyOverrides:
    """Fields of :class:`SafetyLimits` that somebody has set; None leaves a field as proposed or at its default.

    Raises:
        ConfigurationError: the values are out of range or contradict one another.
    """

    fence_enu_m: Polygon | None = None
    floor_m: float | None = None
    ceiling_m: float | None = None
    no_go_enu_m: tuple[Polygon, ...] | None = None
    margin_m: float | None = None
    no_go_margin_m: float | None = None
    separation_m: float | None = None
    hold_horizontal_m: float | None = None
    hold_vertical_m: float | None = None
    max_link_age_s: float | None = None
    max_position_age_s: float | None = None
    min_battery_fraction: float | None = None
    battery_per_m: float | None = None

    def __post_init__(self) -> None:
        self.applied_to(UNLIMITED)

    def applied_to(self, limits: SafetyLimits) -> SafetyLimits:
        """Return the limits with these values in place of their own.

        Raises:
            ConfigurationError: the values contradict those of the limits.
        """
        given = {entry.name: value for entry in fields(self) if (value := getattr(self, entry.name)) is not None}
        return replace(limits, **given)
