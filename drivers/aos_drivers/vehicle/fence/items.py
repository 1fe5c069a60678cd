"""Conversion between a geofence and MAVLink mission items (https://mavlink.io/en/services/geofence.html)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_gcs.ports import Geofence, LatLon

FENCE: int = mavlink.MAV_MISSION_TYPE_FENCE
_INSIDE: int = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
_OUTSIDE: int = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION


def items_of(fence: Geofence, target: Target) -> list[mavlink.MAVLink_mission_item_int_message]:
    """Return the items of the polygons; the ceiling is set by parameters."""
    polygons = [(_INSIDE, fence.inclusion_deg), *((_OUTSIDE, polygon) for polygon in fence.exclusions_deg)]
    vertices = [(command, len(polygon), vertex) for command, polygon in polygons for vertex in polygon]
    return [
        mavlink.MAVLink_mission_item_int_message(
            target.system_id,
            target.component_id,
            seq,
            mavlink.MAV_FRAME_GLOBAL,
            command,
            0,
            0,
            float(count),
            0.0,
            0.0,
            0.0,
            round(latitude_deg * 1e7),
            round(longitude_deg * 1e7),
            0.0,
            FENCE,
        )
        for seq, (command, count, (latitude_deg, longitude_deg)) in enumerate(vertices)
    ]


def polygons_of(
    items: Sequence[mavlink.MAVLink_mission_item_int_message],
) -> tuple[list[tuple[LatLon, ...]], list[tuple[LatLon, ...]], int]:
    """Return inclusion polygons, exclusion polygons, and the number of items that belong to neither."""
    inclusions: list[tuple[LatLon, ...]] = []
    exclusions: list[tuple[LatLon, ...]] = []
    start, others = 0, 0
    while start < len(items):
        command, count = items[start].command, _count(items[start])
        chunk = items[start : start + count]
        if command in (_INSIDE, _OUTSIDE) and len(chunk) == count > 0 and _belong_together(chunk):
            polygon = tuple((item.x / 1e7, item.y / 1e7) for item in chunk)
            (inclusions if command == _INSIDE else exclusions).append(polygon)
            start += count
        else:
            others += 1
            start += 1
    return inclusions, exclusions, others


def _count(item: mavlink.MAVLink_mission_item_int_message) -> int:
    """Return how many vertices the polygon of an item has, 0 where that cannot be."""
    return round(item.param1) if 0.5 < item.param1 < 1e4 else 0


def _belong_together(items: Iterable[mavlink.MAVLink_mission_item_int_message]) -> bool:
    return len({(item.command, item.param1) for item in items}) == 1
