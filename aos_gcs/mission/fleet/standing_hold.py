"""A hold of all vehicles that reaches those, too, which are found in the air a little later."""

from __future__ import annotations

import math
from collections.abc import Iterable

from aos_gcs.mission.fleet.member import Member

STANDING_S = 15.0
"""Time for which a hold stands: after a restart all that is heard and flies is known by then."""
NONE_HELD = (
    f"No vehicle is known to fly, so none was held. Those that are found in the air within {STANDING_S:.0f} s are "
    "held: until then use the remote control."
)
"""Answer to a hold of all that reaches no vehicle."""


class StandingHold:
    """Vehicles that an operator's hold of all has not reached yet, because nothing is known of them."""

    def __init__(self) -> None:
        self._until_s = -math.inf
        self._held: set[int] = set()

    def begin(self, now_s: float, held_ids: Iterable[int]) -> None:
        """Note a hold of all, and the vehicles that it has reached."""
        self._until_s, self._held = now_s + STANDING_S, set(held_ids)

    def end(self) -> None:
        """Note that an operator has ordered something else."""
        self._until_s = -math.inf

    def take_due(self, members: Iterable[Member], now_s: float) -> list[Member]:
        """Return the vehicles to hold now, each once; those that a pilot flies are left alone."""
        if now_s > self._until_s:
            return []
        due = [one for one in members if one.vehicle_id not in self._held and one.airborne and not one.has_pilot]
        self._held |= {member.vehicle_id for member in due}
        return due
