"""The newest state of a mission, for one channel: never more than one waits."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import VehicleSnapshot

STALE_S = 5.0
"""Age of a position, or of the whole state, from which it is not shared any more."""


@dataclass(frozen=True, slots=True)
class SeenState:
    """State of a mission, and when it was so."""

    snapshot: MissionSnapshot
    published_at_s: float
    """Real seconds of the clock that the processes share."""

    def fresh_vehicles(self, now_s: float) -> tuple[VehicleSnapshot, ...]:
        """Return the vehicles whose positions are recent; none if the mission itself has been silent for too long.

        Args:
            now_s: real seconds of the clock that the processes share.
        """
        if now_s - self.published_at_s > STALE_S:
            return ()
        return tuple(
            vehicle
            for vehicle in self.snapshot.vehicles
            if vehicle.position_enu_m is not None and vehicle.link_age_s is not None and vehicle.link_age_s <= STALE_S
        )


class Newest:
    """Holds the newest state; one that was not taken is replaced."""

    def __init__(self) -> None:
        self._state: SeenState | None = None
        self._is_new = asyncio.Event()

    def put(self, state: SeenState) -> None:
        """Replace the state; returns at once."""
        self._state = state
        self._is_new.set()

    async def wait(self, timeout_s: float) -> SeenState | None:
        """Wait for a newer state, and return the newest after this time at the latest; None before the first."""
        try:
            async with asyncio.timeout(timeout_s):
                await self._is_new.wait()
        except TimeoutError:
            pass
        self._is_new.clear()
        return self._state
