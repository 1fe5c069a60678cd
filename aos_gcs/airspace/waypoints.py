"""Planned waypoints, and what safety makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from aos_gcs.geometry.geodesy import EnuPoint


class WaypointVerdict(StrEnum):
    """What safety has made of a planned waypoint."""

    SENT = "sent"
    SHORTENED = "shortened"
    HELD = "held"


@dataclass(frozen=True, slots=True)
class WaypointRecord:
    """One vehicle's planned waypoint of a step."""

    vehicle_id: int
    requested_enu_m: EnuPoint
    sent_enu_m: EnuPoint | None
    """None when the vehicle was held in place."""
    verdict: WaypointVerdict
    reason: str
