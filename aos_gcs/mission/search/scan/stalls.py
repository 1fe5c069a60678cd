"""A scan that is stuck in front of a blocked stretch: when it counts as stuck, and where it continues.

Legs are not cut at no-go zones when they are planned: most zones block a part of the line, and the rest may pass. What
blocks a vehicle may also be the geofence or another vehicle, which is known in flight alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aos_gcs.planning.legs import ScanLeg
from aos_gcs.swarm.line import line_places

FloatArray = NDArray[np.float64]

STALLED_STEPS = 5
"""Steps in a row without ground gained that count as stuck: one or two pass while a vehicle rounds a corner or lets
another go first, and each costs a few seconds of hovering."""

_MIN_IN_LINE = 2
"""Least number of vehicles with free places where a line continues; a single one is no line."""


class StallWatch:
    """Counts the steps in which a scan gains no ground because waypoints are shortened or held.

    Args:
        least_gain_m: smallest advance that is progress; less is how exactly vehicles hover, their arrival radius.
    """

    def __init__(self, least_gain_m: float) -> None:
        self._least_gain_m = least_gain_m
        self.restart()

    def restart(self) -> None:
        """Discard what was counted: the line has been formed anew."""
        self._furthest_m = -math.inf
        self._steps = 0

    def is_stuck(self, along_m: float, *, barred: bool) -> bool:
        """Note a step, and return whether the scan is stuck.

        Args:
            along_m: position of the middle of the swarm along the leg.
            barred: whether a waypoint of the step before was not sent as it was planned.
        """
        if not barred or along_m - self._furthest_m >= self._least_gain_m:
            self._furthest_m, self._steps = along_m, 0
            return False
        self._steps += 1
        return self._steps >= STALLED_STEPS


def place_ahead_m(
    leg: ScanLeg, n: int, spacing_m: float, is_free: Callable[[FloatArray], NDArray[np.bool_]]
) -> float | None:
    """Return how far ahead on a leg the line continues: the first place where all its vehicles have free places.

    Where there is none, the first one where as many as possible do. Places are one spacing apart, less than what a
    camera sees, and the first is one spacing away, so that a scan that is stuck again and again still ends.

    Args:
        leg: rest of the leg.
        n: number of vehicles.
        spacing_m: distance of the vehicles in the line, c4.
        is_free: returns which places, shape (k, 2), can be reached, shape (k,).

    Returns:
        Metres; None if there is no such place before the end of the leg.
    """
    ahead_m = np.arange(spacing_m, leg.length_m, spacing_m)
    if len(ahead_m) == 0:
        return None
    direction_enu = np.array(leg.direction_enu)
    line_m = line_places(np.array(leg.start_enu_m), direction_enu, n, spacing_m)
    places_m = line_m + ahead_m[:, None, None] * direction_enu
    in_line = is_free(places_m.reshape(-1, 2)).reshape(len(ahead_m), n).sum(axis=1)
    best = int(in_line.argmax())
    return float(ahead_m[best]) if in_line[best] >= _MIN_IN_LINE else None
