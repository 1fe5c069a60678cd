"""Jumps of a vehicle's reported position: distances that its own velocity, by its own clock, does not explain."""

from __future__ import annotations

import math

from aos_gcs.geometry.geodesy import GeodeticPosition

JUMP_M = 3.0
"""Horizontal distance from which a difference counts: resets of an estimator by less are everyday."""
ACCELERATION_MPS2 = 5.0
"""Change of velocity between two reports that the velocities at both ends do not show."""
GAP_S = 3.0
"""Time between two reports from which they are not compared: the vehicle may have flown anywhere."""
_DEGREE_M = 111_320.0
"""Length of a degree of latitude."""


class PositionJumps:
    """Adds up the jumps between one report and the next; by the vehicle's own clock, no delay looks like one."""

    __slots__ = ("_last", "total_m")

    def __init__(self) -> None:
        self._last: tuple[float, GeodeticPosition, tuple[float, float, float]] | None = None
        """The latest report: the vehicle's time since boot in seconds, position and velocity."""
        self.total_m = (0.0, 0.0)
        """Sum of all jumps, east and north; about 0 again once the reports have jumped back."""

    def take(self, position: GeodeticPosition, velocity_enu_mps: tuple[float, float, float], boot_ms: int) -> None:
        """Take in a report.

        Args:
            position: reported position.
            velocity_enu_mps: velocity of the same report.
            boot_ms: the vehicle's time since boot of the report.
        """
        boot_s = boot_ms / 1000
        last, self._last = self._last, (boot_s, position, velocity_enu_mps)
        if last is None:
            return
        last_boot_s, last_position, (last_east_mps, last_north_mps, _) = last
        elapsed_s = boot_s - last_boot_s
        if not 0.0 < elapsed_s <= GAP_S:
            return
        east_mps, north_mps, _ = velocity_enu_mps
        to_north_deg = position.latitude_deg - last_position.latitude_deg
        to_east_deg = (position.longitude_deg - last_position.longitude_deg + 180.0) % 360.0 - 180.0
        east_degree_m = _DEGREE_M * math.cos(math.radians(position.latitude_deg))
        east_m = to_east_deg * east_degree_m - elapsed_s * (last_east_mps + east_mps) / 2.0
        north_m = to_north_deg * _DEGREE_M - elapsed_s * (last_north_mps + north_mps) / 2.0
        if math.hypot(east_m, north_m) > JUMP_M + ACCELERATION_MPS2 * elapsed_s**2 / 2.0:
            self.total_m = self.total_m[0] + east_m, self.total_m[1] + north_m
