"""Bounds of a flight: the safety limits in force, the ground that they refer to, and the paths within them."""

from __future__ import annotations

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.terrain import GroundRaster


class FlightBounds:
    """Bounds of all flights by one plan: what prepares them sets the bounds, what flies them looks them up.

    Args:
        arrival_radius_m: distance at which a vehicle is at a place.
        limits: safety limits that are known already, as those of a flight that is taken up; None: not yet.
    """

    def __init__(self, arrival_radius_m: float, limits: SafetyLimits | None = None) -> None:
        self._arrival_radius_m = arrival_radius_m
        self._limits: SafetyLimits | None = None
        self._ground: GroundRaster | None = None
        self._detours: Detours | None = None
        if limits is not None:
            self.set(limits)

    def set(self, limits: SafetyLimits, ground: GroundRaster | None = None) -> None:
        """Keep vehicles within these limits from now on.

        Args:
            limits: safety limits.
            ground: ground that they refer to; None: it counts as level, or is not surveyed yet.
        """
        self._limits, self._ground = limits, ground
        self._detours = Detours(limits.boundaries(), self._arrival_radius_m)

    @property
    def limits(self) -> SafetyLimits | None:
        """Safety limits; without them no waypoint is sent."""
        return self._limits

    @property
    def ground(self) -> GroundRaster | None:
        """Ground that the limits refer to; None: it counts as level."""
        return self._ground

    @property
    def in_force(self) -> SafetyLimits:
        """Safety limits, where vehicles cannot be flown without.

        Raises:
            RuntimeError: there are none yet; a defect of the caller.
        """
        if self._limits is None:
            raise RuntimeError("no safety limits: preflight has not passed")
        return self._limits

    @property
    def detours(self) -> Detours:
        """Admissible paths within the limits.

        Raises:
            RuntimeError: there are no limits yet; a defect of the caller.
        """
        if self._detours is None:
            raise RuntimeError("no safety limits: preflight has not passed")
        return self._detours

    @property
    def bottom_m(self) -> float:
        """Height above the origin down to which vehicles may descend."""
        return 0.0 if self._ground is None else min(0.0, self._ground.bottom_m)
