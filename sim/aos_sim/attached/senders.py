"""Senders by system id, so that no camera takes the pose of another vehicle."""

from __future__ import annotations

from dataclasses import dataclass

from aos_sim.links import Address

SILENT_S = 5.0
"""A sender that was silent for this long may be followed by another one with its id."""


@dataclass(frozen=True, slots=True)
class Sender:
    """Somebody at the other end of a link."""

    link: int
    """Number of the link."""
    address: Address

    def __str__(self) -> str:
        return f"{self.address[0]}:{self.address[1]}"


@dataclass(slots=True)
class _Owner:
    sender: Sender
    heard_at_s: float
    contested_until_s: float = 0.0


class SenderTable:
    """The sender of each system id: the first that is heard with it, until it falls silent."""

    def __init__(self) -> None:
        self._owners: dict[int, _Owner] = {}

    def hear(self, system_id: int, sender: Sender, now_s: float) -> bool:
        """Note a packet of an autopilot; return whether it comes from the sender that the id belongs to.

        Another one makes the id ambiguous until it has been silent for ``SILENT_S``.
        """
        owner = self._owners.get(system_id)
        if owner is None or (owner.sender != sender and now_s - owner.heard_at_s > SILENT_S):
            owner = self._owners[system_id] = _Owner(sender, now_s)
        if owner.sender == sender:
            owner.heard_at_s = now_s
            return True
        owner.contested_until_s = now_s + SILENT_S
        return False

    def sender_of(self, system_id: int) -> Sender:
        """Return the sender that an id belongs to."""
        return self._owners[system_id].sender

    def is_ambiguous(self, system_id: int, now_s: float) -> bool:
        """Whether two senders use an id."""
        owner = self._owners.get(system_id)
        return owner is not None and now_s < owner.contested_until_s
