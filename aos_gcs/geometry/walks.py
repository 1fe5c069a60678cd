"""Ways on which simulated persons walk: what the simulator shows and what its truth is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Walk:
    """A way to and fro along a straight line, begun in its middle."""

    speed_mps: float
    length_m: float
    heading_rad: float
    """First direction, clockwise from north."""

    def at(self, at_s: float) -> tuple[tuple[float, float], float]:
        """Return the offset from the middle, east and north in metres, and the heading, seconds after the beginning."""
        way_m = (self.speed_mps * at_s + self.length_m / 2.0) % (2.0 * self.length_m)
        is_back = way_m >= self.length_m
        ahead_m = (2.0 * self.length_m - way_m if is_back else way_m) - self.length_m / 2.0
        offset_enu_m = ahead_m * math.sin(self.heading_rad), ahead_m * math.cos(self.heading_rad)
        return offset_enu_m, self.heading_rad + math.pi * is_back
