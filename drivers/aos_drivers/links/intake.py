"""Limits of what is read from the links, so that nobody who reaches a port can keep the station from its vehicles.

All limits count bytes and packets, not time: they work the same on a busy machine.
"""

from __future__ import annotations

from collections.abc import Collection

from aos_drivers.links.address import PeerAddress
from aos_gcs.token_bucket import TokenBucket

MAX_DATAGRAM_BYTES = 2048
"""Largest datagram that is read: several packets in one, as routers send them, in one Ethernet frame."""
_GARBAGE_BYTES_PER_S = 2048.0
_GARBAGE_BURST_BYTES = 8192.0
_PEER_BYTES_PER_S = 150_000.0
"""Ten vehicles behind one router at PX4's rates as delivered; a hundred at ours."""
_PEER_BURST_BYTES = 500_000.0
_ALL_BYTES_PER_S = 150_000.0
_ALL_BURST_BYTES = 1_500_000.0
_LUMP_BYTES = 1400
"""Clean bytes of one address that are booked together: booking takes longer than reading a packet's header."""
_NEW_PEERS_PER_S = 50.0
_NEW_PEERS_BURST = 1024.0


class PeerIntake:
    """Budgets of one address. What is valid earns what noise costs: a bad line is not shut out, only noise is."""

    __slots__ = ("_bytes", "_garbage", "is_settled", "unbooked")

    def __init__(self) -> None:
        self._garbage = TokenBucket(_GARBAGE_BYTES_PER_S, _GARBAGE_BURST_BYTES)
        self._bytes = TokenBucket(_PEER_BYTES_PER_S, _PEER_BURST_BYTES)
        self.is_settled = False
        """Whether both budgets were in credit when they were last booked: less than a lump has come since."""
        self.unbooked = 0
        """Clean bytes of less than a lump."""

    def settle(self, now_s: float) -> bool:
        """Return whether bytes of this address are to be read now."""
        self.is_settled = self._garbage.left(now_s) > 0.0 and self._bytes.left(now_s) > 0.0
        return self.is_settled

    def book(self, received: int, dropped: int) -> int:
        """Book bytes that were read, of which some were noise; return how many were booked, with those before."""
        booked = self.unbooked + received
        self._garbage.spend(2 * dropped - booked if dropped < booked else dropped)
        self._bytes.spend(booked)
        self.unbooked, self.is_settled = 0, False
        return booked


class Intake:
    """Budget that all addresses share, except those of vehicles in flight."""

    def __init__(self) -> None:
        self._bytes = TokenBucket(_ALL_BYTES_PER_S, _ALL_BURST_BYTES)
        self._new_peers = TokenBucket(_NEW_PEERS_PER_S, _NEW_PEERS_BURST)
        self._is_settled = False
        self.protected: Collection[PeerAddress] = frozenset()
        """Addresses that vehicles in flight own: they are always read."""

    def admits(self, peer: PeerAddress, budget: PeerIntake | None, now_s: float) -> bool:
        """Return whether to read bytes of an address; ``budget`` is None for one that is new."""
        if budget is not None and budget.is_settled and self._is_settled:
            return True  # as for nearly all datagrams
        if peer in self.protected:
            return True
        if not self._is_settled:
            self._is_settled = self._bytes.left(now_s) > 0.0
        return self._is_settled and (
            self._new_peers.take(1.0, now_s) if budget is None else budget.is_settled or budget.settle(now_s)
        )

    def spend(self, peer: PeerAddress, budget: PeerIntake, received: int, dropped: int) -> None:
        """Note what was read from an address, and how much of it was noise."""
        if peer in self.protected:
            return
        if not dropped and budget.unbooked + received < _LUMP_BYTES:
            budget.unbooked += received
            return
        self._bytes.spend(budget.book(received, dropped))
        self._is_settled = False
