"""Reports that must be repeated before they count.

Whoever can forge a vehicle's address can send one packet at any time. What makes the station less careful, such as a
landing, therefore takes two reports of the same with none in between that says otherwise.
"""

from __future__ import annotations

import math

from aos_gcs.geometry.geodesy import GeodeticPosition

_APART_S = 0.3
"""Least time between both reports: copies of a packet, and packets from one queue, prove nothing."""
_EARTH_M_PER_DEG = 111_320.0
_JUMP_M = 10.0
"""Distance that a position may change by from one report to the next, beside what a vehicle flies meanwhile."""
_FASTEST_MPS = 40.0
_FRESH_S = 3.0
"""Age from which the former position says nothing about a new one."""


class Confirmation:
    """A claim that counts from its second report on."""

    __slots__ = ("_since_s",)

    def __init__(self) -> None:
        self._since_s = math.inf
        """Time of the first report; infinity without one."""

    def claim(self, now_s: float) -> bool:
        """Return whether the claim, reported now, counts."""
        self._since_s = min(self._since_s, now_s)
        return now_s - self._since_s >= _APART_S

    def deny(self) -> None:
        """Note a report that says otherwise."""
        self._since_s = math.inf


class JumpFilter:
    """Positions farther from the former one than a vehicle can fly: they count from the second in a row on."""

    __slots__ = ("_doubted",)

    def __init__(self) -> None:
        self._doubted: tuple[GeodeticPosition, float] | None = None

    def admits(
        self, position: GeodeticPosition, now_s: float, former: GeodeticPosition | None, former_at_s: float | None
    ) -> bool:
        """Return whether a position counts; ``former`` is the last one that did."""
        if former is None or former_at_s is None or _can_follow(position, former, now_s - former_at_s):
            self._doubted = None
            return True
        if self._doubted is not None and _can_follow(position, self._doubted[0], now_s - self._doubted[1]):
            self._doubted = None
            return True
        self._doubted = position, now_s
        return False


def _can_follow(position: GeodeticPosition, former: GeodeticPosition, elapsed_s: float) -> bool:
    if elapsed_s > _FRESH_S:
        return True
    north_m = _EARTH_M_PER_DEG * (position.latitude_deg - former.latitude_deg)
    east_m = _EARTH_M_PER_DEG * (position.longitude_deg - former.longitude_deg)
    east_m *= math.cos(math.radians(former.latitude_deg))
    up_m = position.altitude_amsl_m - former.altitude_amsl_m
    return math.hypot(east_m, north_m, up_m) <= _JUMP_M + _FASTEST_MPS * max(elapsed_s, 0.0)
