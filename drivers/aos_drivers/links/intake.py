"""Limits of what is read from the links, so that nobody who reaches a port can keep the station from its vehicles.

All limits count bytes and packets, not time: they work the same on a busy machine.
"""

from __future__ import annotations

from collections.abc import Collection

from aos_drivers.links.address import PeerAddress

MAX_DATAGRAM_BYTES = 2048
"""Largest datagram that is read: several packets in one, as routers send them, in one Ethernet frame."""
_GARBAGE_BYTES_PER_S = 2048.0
_GARBAGE_BURST_BYTES = 8192.0
_PEER_BYTES_PER_S = 150_000.0
"""Ten vehicles behind one router at PX4's rates as delivered; a hundred at ours."""
_PEER_BURST_BYTES = 500_000.0
_ALL_BYTES_PER_S = 150_000.0
_ALL_BURST_BYTES = 1_500_000.0
_NEW_PEERS_PER_S = 50.0
_NEW_PEERS_BURST = 1024.0


class _Bucket:
    """Amount that may be spent: grows with time up to a burst. A debt is paid off first."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._left = burst
        self._at_s: float | None = None

    def left(self, now_s: float) -> float:
        elapsed_s = 0.0 if self._at_s is None else max(0.0, now_s - self._at_s)
        self._at_s = now_s
        self._left = min(self._burst, self._left + elapsed_s * self._per_s)
        return self._left

    def spend(self, amount: float) -> None:
        self._left = min(self._burst, self._left - amount)


class PeerIntake:
    """Budgets of one address. What is valid earns what noise costs: a bad line is not shut out, only noise is."""

    def __init__(self) -> None:
        self._garbage = _Bucket(_GARBAGE_BYTES_PER_S, _GARBAGE_BURST_BYTES)
        self._bytes = _Bucket(_PEER_BYTES_PER_S, _PEER_BURST_BYTES)

    def admits(self, now_s: float) -> bool:
        """Return whether bytes of this address are to be read now."""
        return self._garbage.left(now_s) > 0.0 and self._bytes.left(now_s) > 0.0

    def spend(self, received: int, dropped: int) -> None:
        """Note how many bytes were read and how many of them were noise."""
        self._garbage.spend(dropped - max(0, received - dropped))
        self._bytes.spend(received)


class Intake:
    """Budget that all addresses share, except those of vehicles in flight."""

    def __init__(self) -> None:
        self._bytes = _Bucket(_ALL_BYTES_PER_S, _ALL_BURST_BYTES)
        self._new_peers = _Bucket(_NEW_PEERS_PER_S, _NEW_PEERS_BURST)
        self.protected: Collection[PeerAddress] = frozenset()
        """Addresses that vehicles in flight own: they are always read."""
        self.refused_bytes = 0

    def admits(self, size: int, peer: PeerAddress, budget: PeerIntake | None, now_s: float) -> bool:
        """Return whether to read ``size`` bytes of an address; ``budget`` is None for one that is new."""
        if peer in self.protected:
            return True
        is_admitted = self._bytes.left(now_s) > 0.0 and (
            self._admits_new(now_s) if budget is None else budget.admits(now_s)
        )
        if not is_admitted:
            self.refused_bytes += size
        return is_admitted

    def spend(self, peer: PeerAddress, budget: PeerIntake, received: int, dropped: int) -> None:
        """Note what was read from an address, and how much of it was noise."""
        if peer not in self.protected:
            budget.spend(received, dropped)
            self._bytes.spend(received)

    def _admits_new(self, now_s: float) -> bool:
        if self._new_peers.left(now_s) < 1.0:
            return False
        self._new_peers.spend(1.0)
        return True
