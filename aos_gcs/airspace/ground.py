"""Launch and return points: whether vehicles may stand there, and whether a path leads to the search area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.separation import TOLERANCE_M

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Obstruction:
    """Reason why a place cannot be used, and the remedy."""

    text: str
    remedy: str


class Ground:
    """The ground within a mission's limits.

    Args:
        limits: geofence, no-go zones, and the margins that are kept from them.
        slack_m: distance by which vehicles may miss their waypoints.
    """

    def __init__(self, limits: SafetyLimits, slack_m: float) -> None:
        self._boundaries = limits.boundaries()
        self._detours = Detours(self._boundaries, slack_m)

    def at(self, place_enu_m: FloatArray) -> Obstruction | None:
        """Return why vehicles cannot stand and land at a place, shape (2,); None if they can."""
        for boundary in self._boundaries:
            depth_m = boundary.depth_m(place_enu_m)
            if depth_m < 0.0 and boundary.keeps_in:
                return Obstruction(f"outside of {boundary.name}", "move it, or widen the geofence")
            if depth_m < 0.0:
                return Obstruction(f"inside of {boundary.name}", "move one of them")
            if depth_m < boundary.margin_m - TOLERANCE_M:
                text = f"{depth_m:.1f} m from {boundary.name}, within the margin of {boundary.margin_m:g} m"
                return Obstruction(text, "move it, or lower the margin")
        return None

    def between(self, start_enu_m: FloatArray, end_enu_m: FloatArray) -> Obstruction | None:
        """Return why no path joins two places, shape (2,) each; None if one does.

        An end inside of a no-go zone is replaced by the nearest place outside of it, as in flight.
        """
        if self._detours.has_path(start_enu_m, self._detours.reachable(end_enu_m)):
            return None
        return Obstruction("cut off from the search area by the geofence or no-go zones", "make a passage, or move it")
