"""The heading that a vehicle has been told to turn to, and whether it has done so.

No safety rests on a heading: a vehicle whose autopilot does not turn is asked again, but not waited for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

TURN_S = 8.0
"""Longest time for a turn: half a turn takes 3 to 6 s at the rates that autopilots come with."""
TOLERANCE_RAD = math.radians(3.0)
"""Difference at which a vehicle heads where it was told to."""
SETTLE_S = 0.5
"""Time for which it does before the turn is over: images taken in a turn err by its rate times the clock's error."""

_NOT_TURNED_RAD = math.pi / 2
"""Difference from which a vehicle has not turned at all: wind turns one by a few degrees."""


@dataclass(slots=True)
class Turn:
    """Turn of one vehicle."""

    heading_rad: float | None = None
    """Heading that was asked for, clockwise from north; None: the autopilot's own rule."""
    until_s: float = -math.inf
    """Time at which it is no longer waited for."""
    reached_s: float | None = None
    """Time since which the vehicle has been seen to head there."""
    is_refused: bool = False
    """Whether the vehicle had not turned when it was last asked to; until it has, no vehicle waits for it."""

    def order(self, heading_rad: float | None, present_rad: float | None, now_s: float) -> None:
        """Note a heading that the vehicle is told.

        Args:
            heading_rad: new heading; None: the autopilot's own rule.
            present_rad: heading by telemetry; None: not known.
            now_s: time.
        """
        if now_s >= self.until_s and self.heading_rad is not None:
            self.is_refused = self._off_rad(present_rad) >= _NOT_TURNED_RAD
        self.heading_rad = heading_rad
        self.until_s = now_s if self.is_refused else now_s + TURN_S
        self.reached_s = None

    def look(self, present_rad: float | None, now_s: float) -> None:
        """Note the heading by telemetry, which None leaves open."""
        if self._off_rad(present_rad) > TOLERANCE_RAD:
            self.reached_s = None
        elif self.reached_s is None:
            self.reached_s = now_s

    def is_over(self, now_s: float) -> bool:
        """Return whether the vehicle has been seen to have turned, or has had the time for it."""
        if self.heading_rad is None or now_s >= self.until_s:
            return True
        return self.reached_s is not None and now_s - self.reached_s >= SETTLE_S

    def _off_rad(self, present_rad: float | None) -> float:
        """Return how far it still has to turn; 0 where nothing was asked for, or nothing is known."""
        if self.heading_rad is None or present_rad is None:
            return 0.0
        return abs(math.remainder(present_rad - self.heading_rad, math.tau))
