"""Plan of a relay: when each vehicle of the line has to be relieved, so that replacements suffice for all of them."""

from __future__ import annotations

import math
from collections.abc import Mapping


def relief_times_s(
    lasts_s: Mapping[int, float], replacements: int, turnaround_s: float, apart_s: float
) -> dict[int, float]:
    """Return the latest time from now at which each vehicle has to be relieved, by id, the earliest first.

    Batteries that were full together are empty together. Each replacement relieves one vehicle after another: one
    that was relieved needs the turnaround before it can relieve the next, so that the first ones leave long before they
    have to. A time in the past means at once. Without replacements each leaves when its battery says so.

    Args:
        lasts_s: time for which each vehicle's battery lasts in the line, by id.
        replacements: vehicles that take turns with those of the line.
        turnaround_s: time from a vehicle's relief until it can relieve another one.
        apart_s: shortest time between two reliefs.
    """
    order = sorted(lasts_s, key=lambda vehicle_id: (lasts_s[vehicle_id], vehicle_id))
    times_s = [lasts_s[vehicle_id] for vehicle_id in order]
    if replacements > 0:
        for place in reversed(range(len(order))):
            next_s = times_s[place + 1] - apart_s if place + 1 < len(order) else math.inf
            turn = place + replacements
            turn_s = times_s[turn] - turnaround_s if turn < len(order) else math.inf
            times_s[place] = min(times_s[place], next_s, turn_s)
    return dict(zip(order, times_s, strict=True))
