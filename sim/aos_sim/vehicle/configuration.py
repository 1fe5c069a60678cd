"""What distinguishes one vehicle from another, and where it may fly."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from aos_gcs.geometry.geodesy import LocalFrame
from aos_sim.vehicle.kinematics import EnuPoint


@dataclass(frozen=True, slots=True)
class VehicleIdentity:
    """Who a vehicle is and where its world lies."""

    system_id: int
    frame: LocalFrame
    uid: int
    """The flight controller board's own number."""
    start_up_s: float | None = None
    """From power-on to a position estimate; None: what the flavour usually needs."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Values that differ from the flavour's settings."""


@dataclass(frozen=True, slots=True)
class Fence:
    """A cylinder about home; infinite where it is switched off."""

    radius_m: float = math.inf
    ceiling_m: float = math.inf

    def contains(self, point_enu_m: EnuPoint, home_enu_m: EnuPoint) -> bool:
        """Whether a point lies inside."""
        return (
            math.dist(point_enu_m[:2], home_enu_m[:2]) <= self.radius_m
            and point_enu_m[2] - home_enu_m[2] <= self.ceiling_m
        )
