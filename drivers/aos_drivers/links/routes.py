"""Choice of the address for a vehicle that is heard over several links, and detection of repeated packets."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.loss import LossCounter

SILENT_S = 2.0
"""An address that brings nothing for this long is left for another one that does."""
DUPLICATE_WINDOW_S = 1.0
"""The same packet from another address within this time is the same packet."""
_BETTER_BY = 0.1
"""A living address is left for one that loses this share of packets less, ..."""
_DWELL_S = 10.0
"""... but not more often than this, ..."""
_JUDGED_PACKETS = 20
"""... nor before both have brought this many."""
_MAX_ADDRESSES = 8
_MAX_PACKETS = 1024


@dataclass(slots=True)
class _Path:
    heard_at_s: float = -math.inf
    loss: LossCounter = field(default_factory=LossCounter)

    @property
    def loss_fraction(self) -> float:
        return self.loss.lost / max(1.0, self.loss.lost + self.loss.received)


class ComponentRoute:
    """Addresses that one component is heard from, and the one that packets for it are sent to.

    That one stays until it has been silent for ``SILENT_S`` while another is heard, or until another one that is known
    to lead to the same vehicle loses clearly fewer packets. Bounded to eight, the longest silent is forgotten.
    """

    __slots__ = ("_chosen_at_s", "_paths", "address")

    def __init__(self) -> None:
        self.address: PeerAddress | None = None
        self._paths: dict[PeerAddress, _Path] = {}
        self._chosen_at_s = -math.inf

    def hear(self, address: PeerAddress, sequence: int, now_s: float, is_same_vehicle: bool) -> bool:
        """Count a packet with its sequence number; return whether the chosen address has changed.

        Args:
            address: address of the sender.
            sequence: sequence number, 0 to 255.
            now_s: clock time.
            is_same_vehicle: whether ``address`` is known to lead to the same vehicle as the chosen one.
        """
        path = self._paths.get(address) or self._add(address)
        path.heard_at_s = now_s
        path.loss.count(sequence)
        if address == self.address or not self._is_better(path, now_s, is_same_vehicle):
            return False
        had_address = self.address is not None
        self.address, self._chosen_at_s = address, now_s
        return had_address

    def knows(self, address: PeerAddress) -> bool:
        """Return whether the component was heard from ``address`` before."""
        return address in self._paths

    def count(self, address: PeerAddress, sequence: int) -> None:
        """Count a packet from an address that is known already, for its loss alone."""
        if address in self._paths:
            self._paths[address].loss.count(sequence)

    def living(self, now_s: float) -> int:
        """Return how many addresses were heard within the last ``SILENT_S``."""
        return sum(now_s - path.heard_at_s <= SILENT_S for path in self._paths.values())

    @property
    def heard_at_s(self) -> float:
        """Time of the last packet, from any address."""
        return max((path.heard_at_s for path in self._paths.values()), default=-math.inf)

    @property
    def loss(self) -> LossCounter:
        """The packets of the chosen address."""
        return self._paths[self.address].loss if self.address in self._paths else LossCounter()

    def _add(self, address: PeerAddress) -> _Path:
        if len(self._paths) >= _MAX_ADDRESSES:
            others = [key for key in self._paths if key != self.address]
            del self._paths[min(others, key=lambda key: self._paths[key].heard_at_s)]
        path = self._paths[address] = _Path()
        return path

    def _is_better(self, path: _Path, now_s: float, is_same_vehicle: bool) -> bool:
        chosen = self._paths.get(self.address) if self.address is not None else None
        if chosen is None or now_s - chosen.heard_at_s > SILENT_S:
            return True
        return (
            is_same_vehicle
            and now_s - self._chosen_at_s >= _DWELL_S
            and min(path.loss.received, chosen.loss.received) >= _JUDGED_PACKETS
            and path.loss_fraction + _BETTER_BY < chosen.loss_fraction
        )


class DuplicateFilter:
    """Filter for packets of one vehicle that have already arrived from another address.

    Routers and redundant networks deliver one packet twice. Bounded to 1024 packets, the oldest is forgotten.
    """

    def __init__(self) -> None:
        self._seen: dict[bytes, tuple[PeerAddress, float]] = {}

    def first_sender(self, content: bytes, address: PeerAddress, now_s: float) -> PeerAddress | None:
        """Return the other address that the packet came from before, or None for the first time.

        Args:
            content: the packet without its signature, which differs from link to link.
            address: address of the sender.
            now_s: clock time.
        """
        while self._seen:
            oldest = next(iter(self._seen))
            if len(self._seen) < _MAX_PACKETS and now_s - self._seen[oldest][1] <= DUPLICATE_WINDOW_S:
                break
            del self._seen[oldest]
        first = self._seen.setdefault(content, (address, now_s))[0]
        return first if first != address else None

    def sender_of(self, content: bytes) -> PeerAddress | None:
        """Return the address that a packet came from before; it is not remembered as heard again."""
        return self._seen[content][0] if content in self._seen else None
