"""Which address a system id belongs to, and whether two vehicles use the same one."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_drivers.mavlink.address import PeerAddress

MEMORY_S = 10.0
"""Addresses heard within this time are taken to be in use."""
_RETURNS = 2
"""One return to the former address may be a late packet, two are two senders."""
_REBOOT_MARGIN_MS = 2000
_MAX_ADDRESSES = 8


@dataclass(slots=True)
class _Sighting:
    heard_at_s: float
    uid: bytes | None = None
    boot_ms: int = 0


class Identity:
    """The addresses one system id is heard from. Bounded to eight, the longest silent is forgotten."""

    def __init__(self) -> None:
        self.address: PeerAddress | None = None
        """Where the autopilot was heard last."""
        self._sightings: dict[PeerAddress, _Sighting] = {}
        self._returns_at_s: list[float] = []
        self._clash_until_s = -math.inf

    def hear(self, address: PeerAddress, now_s: float) -> bool:
        """Note a packet of the autopilot component; return whether the address is new."""
        sighting = self._sightings.get(address)
        if sighting is None:
            self._sightings[address] = _Sighting(now_s)
            if len(self._sightings) > _MAX_ADDRESSES:
                oldest = min(self._sightings, key=lambda key: self._sightings[key].heard_at_s)
                del self._sightings[oldest]
        else:
            if address != self.address and now_s - sighting.heard_at_s <= MEMORY_S:
                self._on_return(now_s)
            sighting.heard_at_s = now_s
        self.address = address
        return sighting is None

    def hear_uid(self, address: PeerAddress, uid: bytes, now_s: float) -> None:
        """Note the board's identity that the sender at ``address`` gave."""
        if not any(uid):
            return
        self._sightings[address].uid = uid
        recent = [entry.uid for entry in self._sightings.values() if now_s - entry.heard_at_s <= MEMORY_S]
        if len({entry for entry in recent if entry is not None}) > 1:
            self._clash_until_s = now_s + MEMORY_S

    def hear_boot_time(self, address: PeerAddress, boot_ms: int) -> bool:
        """Return whether the time since boot shows that the sender at ``address`` has restarted."""
        sighting = self._sightings[address]
        has_restarted = boot_ms + _REBOOT_MARGIN_MS < sighting.boot_ms
        sighting.boot_ms = boot_ms
        return has_restarted

    def is_ambiguous(self, now_s: float) -> bool:
        """Whether two senders use this id."""
        return now_s < self._clash_until_s

    def _on_return(self, now_s: float) -> None:
        recent = [at_s for at_s in self._returns_at_s if now_s - at_s <= MEMORY_S]
        self._returns_at_s = [*recent, now_s][-_RETURNS:]
        if len(self._returns_at_s) == _RETURNS:
            self._clash_until_s = now_s + MEMORY_S
