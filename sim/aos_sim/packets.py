"""Bytes to MAVLink messages and back."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink


class Parser:
    """Bytes of one peer to messages; what is damaged or unknown is skipped."""

    def __init__(self) -> None:
        self._codec = mavlink.MAVLink(None)
        self._codec.robust_parsing = True

    def feed(self, data: bytes) -> list[mavlink.MAVLink_message]:
        """Return the messages completed by ``data``."""
        messages = self._codec.parse_buffer(data) or []
        return [message for message in messages if message.get_msgId() >= 0]


class Packer:
    """Messages of one component to packets."""

    def __init__(self, system_id: int, component_id: int) -> None:
        self._codec = mavlink.MAVLink(None, system_id, component_id)

    def pack(self, message: mavlink.MAVLink_message) -> bytes:
        """Return the packet with the component's next sequence number."""
        data: bytes = message.pack(self._codec)
        self._codec.seq = (self._codec.seq + 1) % 256
        return data
