"""A session without a link, and what it sends and tells."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.mavlink.peers import Outgoing
from aos_drivers.mavlink.session import Event, MavlinkSession
from aos_gcs.ports import Notice


def new_session() -> MavlinkSession:
    return MavlinkSession(system_id=254, position_hz=5.0)


def notices(events: list[Event]) -> list[Notice]:
    return [event for event in events if isinstance(event, Notice)]


def decoded(outgoing: list[Outgoing]) -> list[tuple[PeerAddress, mavlink.MAVLink_message]]:
    return [(entry.peer, message) for entry in outgoing for message in FrameParser().feed(entry.packet)]


def requested(outgoing: list[Outgoing], command: int) -> list[int]:
    return [
        int(message.param1)
        for _peer, message in decoded(outgoing)
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_COMMAND_LONG and message.command == command
    ]
