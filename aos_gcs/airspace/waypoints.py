"""Planned waypoints, and the decisions about them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import EnuPoint


class WaypointVerdict(StrEnum):
    """Decision about a planned waypoint."""

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
    is_unfit: bool = False
    """Whether the vehicle is held for its own state, such as an old link or a low battery: nothing bars its path."""
    heading_rad: float | None = None
    """Heading that it is to turn to, clockwise from north; None: its autopilot's own rule."""
    speed_mps: float | None = None
    """Speed at which it flies there; None: the cruise speed."""

    @property
    def is_barred(self) -> bool:
        """Whether something on its path kept the vehicle from flying as planned."""
        return self.verdict is not WaypointVerdict.SENT and not self.is_unfit


def as_enu_point(position_enu_m: NDArray[np.float64]) -> EnuPoint:
    """Return plain floats for a position, shape (3,)."""
    east_m, north_m, up_m = (float(value) for value in position_enu_m)
    return east_m, north_m, up_m
