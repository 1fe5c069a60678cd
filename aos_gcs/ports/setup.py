"""Setup of a vehicle: geofence, failsafes and return height."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

LatLon = tuple[float, float]
"""Latitude and longitude in degrees, WGS84."""

_SAME_PLACE_DEG = 2e-7
"""Autopilots keep integers of 1e-7 degrees, about a centimetre."""
_SAME_HEIGHT_M = 0.1


@dataclass(frozen=True, slots=True)
class Geofence:
    """Limits of a flight that the autopilot itself enforces."""

    inclusion_deg: tuple[LatLon, ...]
    """Polygon to stay in."""
    exclusions_deg: tuple[tuple[LatLon, ...], ...] = ()
    """Polygons to stay out of."""
    ceiling_above_home_m: float | None = None
    radius_about_home_m: float | None = None
    """Limit of the distance from home; we give none."""
    other_items: int = 0
    """Stored items that belong to none of the polygons above, such as circles; we write none."""

    def is_same_as(self, other: Geofence) -> bool:
        """Whether both fences are equal within the resolution of autopilots."""
        rings, other_rings = ((fence.inclusion_deg, *fence.exclusions_deg) for fence in (self, other))
        if [len(ring) for ring in rings] != [len(ring) for ring in other_rings]:
            return False
        return (
            all(
                abs(one - another) <= _SAME_PLACE_DEG
                for ring, other_ring in zip(rings, other_rings, strict=True)
                for vertex, other_vertex in zip(ring, other_ring, strict=True)
                for one, another in zip(vertex, other_vertex, strict=True)
            )
            and _is_same_limit(self.ceiling_above_home_m, other.ceiling_above_home_m)
            and _is_same_limit(self.radius_about_home_m, other.radius_about_home_m)
            and self.other_items == other.other_items
        )


def _is_same_limit(one_m: float | None, other_m: float | None) -> bool:
    if one_m is None or other_m is None:
        return one_m is other_m
    return abs(one_m - other_m) <= _SAME_HEIGHT_M


@dataclass(frozen=True, slots=True)
class Safeguard:
    """A failsafe of an autopilot."""

    is_on: bool
    text: str
    """The action and the setting that says so: ``return after 5 s (FS_GCS_ENABLE = 1)``."""
    remedy: str = ""
    """Setting to change where it is off."""


@dataclass(frozen=True, slots=True)
class VehicleFacts:
    """Firmware and settings of a vehicle: read when asked for, unlike telemetry."""

    firmware: str
    """Version; empty when it is unknown."""
    board_id: str
    """Identifier of the flight controller, in hexadecimal; empty when it has none."""
    link_loss: Safeguard
    """Failsafe for when our heartbeats are no longer heard."""
    low_battery: Safeguard
    arming_checks: Safeguard
    other_failsafes: Safeguard
    """Failsafes for a lost position estimate and for a lost remote control."""
    return_place: Safeguard
    """Whether the autopilot's own return ends at its launch point."""
    fence: Geofence | None
    """None when no geofence is stored."""
    at_fence: Safeguard
    return_height_m: float
    """Height above home to which the autopilot climbs, if it is lower, before its own return."""
    return_climb_m: float
    """Height that it climbs before that, however high it is."""
    return_settings: Mapping[str, float]
    """The autopilot's own settings that say both, for ``Vehicle.restore_return``."""
