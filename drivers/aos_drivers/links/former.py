"""Vehicles of a flight that is taken up: where each was proven to be heard before anything of it is heard now."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.identity import Identity
from aos_drivers.links.ownership import Ownership
from aos_gcs.ports import Clock, FormerLinks, Notice, ProvenLink, Severity

_TOLD_AGAIN_S = 60.0


class FormerOwner:
    """One vehicle of a former flight that has not been heard yet; its id belongs to the addresses that it had then.

    Args:
        vehicle_id: the MAVLink system id.
        links: where the vehicle was proven to be.
        recorded_at_s: time at which that was so; before the clock's start it is negative.
        now_s: present time, from which the addresses count as silent.
        signing_links: numbers of the links on which signatures are checked.
    """

    def __init__(
        self,
        vehicle_id: int,
        links: Sequence[ProvenLink],
        recorded_at_s: float,
        now_s: float,
        signing_links: Collection[int],
    ) -> None:
        self.identity = Identity()
        self.ownership = Ownership(self.identity)
        self._vehicle_id = vehicle_id
        self._told_at_s = -math.inf
        for link in links:
            address = PeerAddress.parse(link.address)
            if address is None:
                continue
            booted_at_s = None if link.since_boot_s is None else recorded_at_s - link.since_boot_s
            self.identity.recall(address, _uid(link.board_id), booted_at_s, now_s)
            self.ownership.recall(address, now_s, is_signed=link.is_signed and address.link in signing_links)

    def admits(self, peer: PeerAddress, now_s: float, *, is_signed: bool = False) -> bool:
        """Return whether a packet from ``peer`` may be that of the vehicle; see ``Ownership``."""
        return self.ownership.admits(peer, is_signed, now_s)

    def take_stranger(
        self, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float, *, is_signed: bool = False
    ) -> Notice | None:
        """Ignore a packet that is not admitted, but for what may prove that it is the vehicle's.

        Returns the notice about its sender, at most once a minute.
        """
        if message.get_srcComponent() != mavlink.MAV_COMP_ID_AUTOPILOT1:
            return None
        self.ownership.hear_stranger(message, peer, now_s, is_signed=is_signed)
        if now_s - self._told_at_s < _TOLD_AGAIN_S:
            return None
        self._told_at_s = now_s
        owners = " and ".join(map(str, self.ownership.owners))
        text = (
            f"heard at {peer}, but it flew at {owners} before this station was restarted: ignored there until it proves"
            " to be the same vehicle. If another one has its system id now, end the program and start it again"
        )
        return Notice(Severity.WARNING, text, self._vehicle_id)


def former_owners(
    former: FormerLinks | None, clock: Clock, signing_links: Collection[int] = ()
) -> dict[int, FormerOwner]:
    """Return the vehicles of a former flight by system id; those whose addresses cannot be read are left out."""
    if former is None:
        return {}
    now_s = clock.now_s()
    recorded_at_s = now_s - (clock.utc_s() - former.recorded_utc_s)
    owners = {
        vehicle_id: FormerOwner(vehicle_id, links, recorded_at_s, now_s, signing_links)
        for vehicle_id, links in former.links.items()
    }
    return {vehicle_id: owner for vehicle_id, owner in owners.items() if owner.ownership.is_claimed}


def _uid(board_id: str) -> bytes | None:
    try:
        return bytes.fromhex(board_id) or None
    except ValueError:
        return None
