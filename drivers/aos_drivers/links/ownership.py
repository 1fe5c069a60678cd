"""Ownership of a system id: while a vehicle is armed, its id belongs to the addresses where it was proven to be."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.boot_time import BOOT_TIMED_IDS
from aos_drivers.links.identity import MEMORY_S, Identity, board_uid
from aos_drivers.links.routes import SILENT_S
from aos_gcs.ports import ProvenLink

_MAX_OWNERS = 6
"""Fewer than an ``Identity`` remembers: an owner must never be forgotten, and a new address has to find room to prove
itself. Each connection of a vehicle, such as one over a mobile network, may bring another port."""


class Ownership:
    """Addresses that may speak for one armed vehicle; whatever else uses its id is ignored.

    A further address has to prove that it leads to the same vehicle: by its board and the moment of its boot, or by the
    same packets. A vehicle whose owners have been silent for ten seconds may be heard from anywhere, unless its board
    is known to be another one. Where the vehicle signs its packets, nothing unsigned speaks for it. Bounded to six
    addresses, the longest silent has to prove itself again.
    """

    __slots__ = ("_identity", "_owners")

    def __init__(self, identity: Identity) -> None:
        self._identity = identity
        self._owners: dict[PeerAddress, bool] = {}
        """Whether the vehicle signs its packets, by address."""

    @property
    def is_claimed(self) -> bool:
        """Whether the id belongs to certain addresses now."""
        return bool(self._owners)

    @property
    def owners(self) -> frozenset[PeerAddress]:
        """Addresses that the id belongs to now."""
        return frozenset(self._owners)

    def claim(self, address: PeerAddress, now_s: float) -> None:
        """Give the id to ``address``, where the vehicle reports that it is armed, and to all proven to be the same."""
        identity = self._identity
        if not self._owners and identity.is_ambiguous(now_s):
            return
        for each in (address, *identity.addresses()):
            if each not in self._owners and (each == address or identity.is_proven_same(address, each)):
                self._owners[each] = identity.is_signed(each)
        self._keep(now_s)

    def recall(self, address: PeerAddress, now_s: float, *, is_signed: bool) -> None:
        """Give the id to ``address``, where the vehicle was proven to be before the start."""
        self._owners[address] = is_signed
        self._keep(now_s)

    def _keep(self, now_s: float) -> None:
        while len(self._owners) > _MAX_OWNERS:
            del self._owners[max(self._owners, key=lambda owner: self._identity.silence_s(owner, now_s))]
        self._identity.keep(self._owners)

    def proofs(self, now_s: float) -> tuple[ProvenLink, ...]:
        """Return the addresses that the id belongs to, and by what the vehicle is known there."""
        return tuple(self._identity.proof(address, now_s) for address in self._owners)

    def release(self) -> None:
        """Give the id up: the vehicle reports that it is disarmed."""
        self._owners.clear()
        self._identity.keep(())

    def admits(self, address: PeerAddress, is_signed: bool, now_s: float) -> bool:
        """Return whether a packet of the autopilot from ``address`` may be that of the vehicle."""
        if not self._owners:
            return True
        if address in self._owners:
            return is_signed or not self._owners[address]
        if any(self._owners.values()) and not is_signed:
            return False
        return self._is_proven(address) or self._is_successor(address, now_s)

    def hear_stranger(
        self, message: mavlink.MAVLink_message, address: PeerAddress, now_s: float, *, is_signed: bool
    ) -> None:
        """Note what a packet of an autopilot that was not admitted may prove about its sender."""
        identity = self._identity
        identity.hear(address, now_s, is_signed=is_signed)
        if message.get_msgId() in BOOT_TIMED_IDS:
            identity.learn_boot_time(address, message.time_boot_ms, now_s)
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            identity.hear_uid(address, board_uid(message), now_s)

    def _is_proven(self, address: PeerAddress) -> bool:
        return any(self._identity.is_proven_same(owner, address) for owner in self._owners)

    def _is_successor(self, address: PeerAddress, now_s: float) -> bool:
        """Return whether a vehicle that has fallen silent may now be the one at ``address``."""
        identity = self._identity
        owner = min(self._owners, key=lambda each: identity.silence_s(each, now_s))
        silence_s = identity.silence_s(owner, now_s)
        if silence_s > SILENT_S and identity.has_restarted_at(owner, address):
            return True
        return silence_s > MEMORY_S and not identity.is_other_board(owner, address)

    def admits_component(self, address: PeerAddress) -> bool:
        """Return whether a component that is not the autopilot may speak from ``address``, new to it."""
        return not self._owners or any(address.host == owner.host for owner in self._owners)
