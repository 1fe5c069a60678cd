"""Detection of two vehicles that use one system id, from the addresses that it is heard from."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.boot_time import REBOOT_PACKETS, SAME_BOOT_S, BootTime
from aos_drivers.links.routes import SILENT_S
from aos_gcs.ports import ProvenLink

MEMORY_S = 10.0
"""Addresses heard within this time are taken to be in use."""
GRACE_S = 3.0
"""Time for which a new address may stay unproven before it counts as that of a second vehicle."""
_RETURNS = 2
"""One return to the former address may be a late packet, two are two senders."""
_PROOFS = 3
"""Number of packets from both addresses that proves that these lead to one vehicle."""
_QUESTIONS = 5
_QUESTION_PAUSE_S = 1.0
_MAX_ADDRESSES = 8


@dataclass(slots=True)
class _Sighting:
    heard_at_s: float
    first_heard_at_s: float
    uid: bytes | None = None
    is_signed: bool = False
    boot: BootTime = field(default_factory=BootTime)
    is_placed: bool = False
    """Whether it is known whose address this is: the first one, or a later one once its boot was compared."""
    shared: dict[PeerAddress, int] = field(default_factory=dict)
    """Packets that came from the other address, too."""
    questions_left: int = _QUESTIONS
    question_due_s: float = -math.inf


class Identity:
    """The addresses one system id is heard from. Bounded to eight, the longest silent is forgotten.

    Two addresses lead to one vehicle when the boards behind both have the same identity and started at the same moment
    (all simulated PX4 have one identity), or when the same packets come from both. Two living addresses without such
    proof are taken for two vehicles.
    """

    __slots__ = ("_clash_until_s", "_kept", "_last", "_returns_at_s", "_sightings")

    def __init__(self) -> None:
        self._last: PeerAddress | None = None
        self._sightings: dict[PeerAddress, _Sighting] = {}
        self._returns_at_s: list[float] = []
        self._clash_until_s = -math.inf
        self._kept: frozenset[PeerAddress] = frozenset()

    @property
    def has_several_addresses(self) -> bool:
        """Whether packets can arrive twice, and two vehicles can use the id."""
        return len(self._sightings) > 1

    def addresses(self) -> list[PeerAddress]:
        """Return the addresses that are remembered."""
        return list(self._sightings)

    def living(self, now_s: float) -> list[PeerAddress]:
        """Return the addresses that are taken to be in use."""
        return [key for key, entry in self._sightings.items() if now_s - entry.heard_at_s <= MEMORY_S]

    def keep(self, addresses: Iterable[PeerAddress]) -> None:
        """Never forget ``addresses``, and forget others before them."""
        self._kept = frozenset(addresses)

    def recall(self, address: PeerAddress, uid: bytes | None, booted_at_s: float | None, now_s: float) -> None:
        """Note the board and the boot that were heard at ``address`` before the start; its silence counts from now."""
        self._sightings[address] = sighting = _Sighting(now_s, now_s, uid=uid, is_placed=True)
        sighting.boot.booted_at_s = booted_at_s

    def proof(self, address: PeerAddress, now_s: float) -> ProvenLink:
        """Return by what the vehicle at ``address`` is known."""
        sighting = self._sightings[address]
        booted_at_s = sighting.boot.booted_at_s
        return ProvenLink(
            address=address.record,
            board_id="" if sighting.uid is None else sighting.uid.hex(),
            since_boot_s=None if booted_at_s is None else now_s - booted_at_s,
            is_signed=sighting.is_signed,
        )

    def is_signed(self, address: PeerAddress) -> bool:
        """Whether packets with a good signature come from ``address``."""
        return address in self._sightings and self._sightings[address].is_signed

    def silence_s(self, address: PeerAddress, now_s: float) -> float:
        """Return the time since ``address`` was heard; infinite for one that is not remembered."""
        sighting = self._sightings.get(address)
        return math.inf if sighting is None else now_s - sighting.heard_at_s

    def hear(self, address: PeerAddress, now_s: float, *, is_signed: bool = False) -> None:
        """Note a packet of the autopilot component, and whether it had a good signature."""
        sighting = self._sightings.get(address)
        if sighting is None:
            sighting = self._sightings[address] = _Sighting(now_s, now_s)
            if len(self._sightings) > _MAX_ADDRESSES:
                self._forget_oldest(address)
        else:
            if address != self._last and now_s - sighting.heard_at_s <= MEMORY_S:
                self._on_return(address, now_s)
            sighting.heard_at_s = now_s
        if is_signed:
            sighting.is_signed = True
        self._last = address

    def hear_twice(self, address: PeerAddress, first: PeerAddress) -> None:
        """Note a packet from ``address`` that had come from ``first`` before. Pass only such that hold a time."""
        if first in self._sightings and address in self._sightings:
            for one, other in ((address, first), (first, address)):
                shared = self._sightings[one].shared
                shared[other] = shared.get(other, 0) + 1
            self._clear_suspicion()

    def hear_uid(self, address: PeerAddress, uid: bytes, now_s: float) -> None:
        """Note the board's identity that the sender at ``address`` gave."""
        if not any(uid):
            return
        self._sightings[address].uid = uid
        recent = {entry.uid for entry in self._sightings.values() if now_s - entry.heard_at_s <= MEMORY_S}
        if len(recent - {None}) > 1:
            self._clash_until_s = now_s + MEMORY_S
        else:
            self._clear_suspicion()

    def hear_boot_time(self, address: PeerAddress, boot_ms: int, now_s: float) -> bool:
        """Return whether the time since boot shows that the vehicle at ``address`` has restarted."""
        sighting = self._sightings[address]
        same = self._same_as(address) if self.has_several_addresses else [sighting]
        if not sighting.boot.hear(boot_ms, now_s):
            return not sighting.is_placed and self._has_moved_by_restart(address, sighting, now_s)
        for entry in same:
            entry.boot.begin_anew(boot_ms, now_s)
        return True

    def learn_boot_time(self, address: PeerAddress, boot_ms: int, now_s: float) -> None:
        """Note the time since boot of a sender that is not taken for the vehicle."""
        self._sightings[address].boot.hear(boot_ms, now_s)

    def _same_as(self, address: PeerAddress) -> list[_Sighting]:
        return [entry for key, entry in self._sightings.items() if self.is_same_vehicle(address, key)]

    def _has_moved_by_restart(self, address: PeerAddress, sighting: _Sighting, now_s: float) -> bool:
        """Return, once, whether a vehicle is heard at a new address since it has restarted."""
        others = {key: entry for key, entry in self._sightings.items() if entry.is_placed and key != address}
        if not others:
            sighting.is_placed = True
            return False
        former = max(others.values(), key=lambda entry: entry.heard_at_s)
        if now_s - former.heard_at_s <= SILENT_S:
            return False  # both are heard: one vehicle on two links, or two vehicles
        if sighting.boot.packets < REBOOT_PACKETS:
            return False
        sighting.is_placed = True
        is_other_board = None not in (sighting.uid, former.uid) and sighting.uid != former.uid
        return not is_other_board and sighting.boot.follows(former.boot, former.heard_at_s)

    def is_same_vehicle(self, one: PeerAddress | None, other: PeerAddress | None) -> bool:
        """Whether both addresses are known to lead to one vehicle."""
        first = self._sightings.get(one) if one is not None else None
        second = self._sightings.get(other) if other is not None else None
        if first is None or second is None or other is None:
            return False
        if first.uid is not None and second.uid is not None:
            return first.uid == second.uid and _started_together(first, second)
        return one == other or first.shared.get(other, 0) >= _PROOFS

    def is_proven_same(self, one: PeerAddress, other: PeerAddress) -> bool:
        """Whether both addresses lead to one vehicle, and the boots behind both are known to be one."""
        if not self.is_same_vehicle(one, other):
            return False
        first, second = self._sightings[one], self._sightings[other]
        are_timed = first.boot.booted_at_s is not None and second.boot.booted_at_s is not None
        return one == other or first.shared.get(other, 0) >= _PROOFS or are_timed

    def is_other_board(self, one: PeerAddress, other: PeerAddress) -> bool:
        """Whether the boards behind both addresses are known to be two."""
        uids = [self._sightings[key].uid if key in self._sightings else None for key in (one, other)]
        return None not in uids and uids[0] != uids[1]

    def has_restarted_at(self, former: PeerAddress, address: PeerAddress) -> bool:
        """Whether the board of ``former`` is heard at ``address`` since a later boot."""
        first, second = self._sightings.get(former), self._sightings.get(address)
        if first is None or second is None or first.uid is None or first.uid != second.uid:
            return False
        return second.boot.packets >= REBOOT_PACKETS and second.boot.follows(first.boot, first.heard_at_s)

    def is_ambiguous(self, now_s: float) -> bool:
        """Whether two senders use this id."""
        return now_s < self._clash_until_s

    def questions(self, now_s: float) -> list[PeerAddress]:
        """Return the addresses at which to request the board's identity now."""
        if not self.has_several_addresses:
            return []
        living = {key: entry for key, entry in self._sightings.items() if now_s - entry.heard_at_s <= MEMORY_S}
        if len(living) < 2:
            return []
        due = [
            key
            for key, entry in living.items()
            if entry.uid is None and entry.questions_left and now_s >= entry.question_due_s
        ]
        for key in due:
            living[key].questions_left -= 1
            living[key].question_due_s = now_s + _QUESTION_PAUSE_S
        return due

    def _forget_oldest(self, newest: PeerAddress) -> None:
        others = [key for key in self._sightings if key != newest]
        candidates = [key for key in others if key not in self._kept] or others
        oldest = min(candidates, key=lambda key: self._sightings[key].heard_at_s)
        del self._sightings[oldest]
        for entry in self._sightings.values():
            entry.shared.pop(oldest, None)

    def _on_return(self, address: PeerAddress, now_s: float) -> None:
        if self.is_same_vehicle(address, self._last):
            return
        recent = [at_s for at_s in self._returns_at_s if now_s - at_s <= MEMORY_S]
        self._returns_at_s = [*recent, now_s][-_RETURNS:]
        known_for_s = now_s - max(
            self._sightings[key].first_heard_at_s for key in (address, self._last) if key in self._sightings
        )
        if len(self._returns_at_s) == _RETURNS and known_for_s >= GRACE_S:
            self._clash_until_s = now_s + MEMORY_S

    def _clear_suspicion(self) -> None:
        """End the suspicion when all addresses have turned out to lead to one vehicle."""
        first, *others = self._sightings
        if all(self.is_same_vehicle(first, other) for other in others):
            self._returns_at_s = []
            self._clash_until_s = -math.inf


def board_uid(message: mavlink.MAVLink_autopilot_version_message) -> bytes:
    """Return the identity of a board; all zero when it has none."""
    return bytes(message.uid2) + int(message.uid).to_bytes(8, "little")


def _started_together(first: _Sighting, second: _Sighting) -> bool:
    if first.boot.booted_at_s is None or second.boot.booted_at_s is None:
        return True
    return abs(first.boot.booted_at_s - second.boot.booted_at_s) <= SAME_BOOT_S
