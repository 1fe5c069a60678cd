"""The height at which autopilots' own returns clear the ground, from everywhere that a plan leads vehicles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.terrain.check import place_text, swept_m, ways_m

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ReturnClearance:
    """The highest ground between vehicles and their launch points, and the height above it that returns keep."""

    ground_up_m: float
    """Height of the ground above the origin."""
    place: str
    """Place of it, in words."""
    floor_m: float
    """Smallest height above the ground."""

    @property
    def least_up_m(self) -> float:
        """Smallest height above the origin that a return may have."""
        return self.ground_up_m + self.floor_m


def return_clearance(
    plan: MissionPlan,
    legs: Sequence[ScanLeg],
    homes_enu_m: Sequence[FloatArray],
    *,
    ground: GroundRaster,
    frame: LocalFrame,
    floor_m: float,
) -> ReturnClearance | None:
    """Return what the straight ways home from everywhere in a plan have to clear; None where no ground is known.

    Args:
        plan: what is flown.
        legs: its legs.
        homes_enu_m: launch points, to which autopilots return.
        ground: ground as vehicles see it that stand at these points.
        frame: local frame.
        floor_m: smallest height above the ground.
    """
    corners_m = [corner_m for leg in legs for corner_m in swept_m(plan, leg)]
    points = [(float(each_m[0]), float(each_m[1])) for each_m in (*homes_enu_m, *corners_m)]
    cells = ground.within([ways_m(plan, points)])
    if np.isnan(cells.highest_m).all():
        return None
    at = int(np.nanargmax(cells.highest_m))
    return ReturnClearance(float(cells.highest_m[at]), place_text(frame, cells.places_enu_m[at]), floor_m)
