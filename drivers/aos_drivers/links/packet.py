"""Messages of received packets: pymavlink's, but decoded when somebody reads them.

Most messages of a vehicle are read by nobody, and of most others a few fields. pymavlink's own decoder takes several
times as long as everything else that is done with a packet.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_V1, _V2 = mavlink.PROTOCOL_MARKER_V1, mavlink.PROTOCOL_MARKER_V2
_HEADER_BYTES = {_V1: 6, _V2: 10}
_CRC_BYTES = 2


class _Unread:
    """An attribute of a message that is found out at its first reading; from then on the message has it itself.

    Unlike with ``__getattr__``, the interpreter reads all other attributes as quickly as those of any object.
    """

    def __init__(self, find_out: Callable[[LazyMessage], None]) -> None:
        self._find_out = find_out
        self._name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, message: LazyMessage | None, owner: type | None = None) -> Any:
        if message is None:
            return self
        self._find_out(message)
        return message.__dict__[self._name]


class LazyMessage(mavlink.MAVLink_message):  # type: ignore[misc]
    """A message with the interface of pymavlink's; its subclasses, one per kind, are made below.

    The packet must be whole, with a valid checksum and no more bytes than its kind can have.
    """

    _kind: type[mavlink.MAVLink_message]
    _spans: tuple[tuple[str, int, int], ...]
    """Name of each field, and where its values begin and end among those that are unpacked."""
    _has_arrays: bool
    _hides_fields: bool
    """Whether fields have the names of pymavlink's own attributes, as ``id``: these cannot be found missing."""
    _message_id: int
    _signed, _link_id, _instances = False, None, None

    def __init__(self, packet: bytes) -> None:
        start = 4 if packet[0] == _V2 else 2
        self._msgbuf = packet
        self._sequence, self._system, self._component = packet[start], packet[start + 1], packet[start + 2]
        if self._hides_fields:
            self.decode()

    def get_msgId(self) -> int:
        """See pymavlink."""
        return self._message_id

    def get_srcSystem(self) -> int:
        """See pymavlink."""
        return self._system

    def get_srcComponent(self) -> int:
        """See pymavlink."""
        return self._component

    def get_seq(self) -> int:
        """See pymavlink."""
        return self._sequence

    def _stop(self) -> int:
        """Return where the payload ends."""
        return _HEADER_BYTES[self._msgbuf[0]] + self._msgbuf[1]

    def values(self) -> tuple[Any, ...]:
        """Return all values of the packet in their order there, as ``struct`` does; decodes no fields."""
        packet, unpacker = self._msgbuf, self._kind.unpacker
        start = _HEADER_BYTES[packet[0]]
        values: tuple[Any, ...]
        if packet[1] >= unpacker.size:
            values = unpacker.unpack_from(packet, start)
        else:  # MAVLink 2 cuts zeros off
            values = unpacker.unpack(packet[start : start + packet[1]].ljust(unpacker.size, b"\0"))
        return values

    def decode(self) -> None:
        """Take the fields out of the packet, as the first reading of one does."""
        values = self.values()
        if self._has_arrays:
            self.__dict__.update(
                (name, values[first] if last == first + 1 else list(values[first:last]))
                for name, first, last in self._spans
            )
        else:
            self.__dict__.update(zip(self._kind.ordered_fieldnames, values))  # noqa: B905 - as many, of one kind

    def _read_header(self) -> None:
        packet = self._msgbuf
        flags = (packet[2], packet[3]) if packet[0] == _V2 else (0, 0)
        self._header = mavlink.MAVLink_header(
            self._message_id, *flags, packet[1], self._sequence, self._system, self._component
        )

    def _read_checksum(self) -> None:
        self._crc = int.from_bytes(self._msgbuf[self._stop() : self._stop() + _CRC_BYTES], "little")

    def _read_payload(self) -> None:
        self._payload = self._msgbuf[_HEADER_BYTES[self._msgbuf[0]] : self._stop()]

    _header, _crc, _payload = _Unread(_read_header), _Unread(_read_checksum), _Unread(_read_payload)


def _lazy_kind(message_id: int, kind: type[mavlink.MAVLink_message]) -> type[LazyMessage] | None:
    """Return the lazy version of a kind of message; None for those with texts, which pymavlink decodes."""
    values = struct.unpack(kind.unpacker.format, bytes(kind.unpacker.size))
    if any(isinstance(value, bytes) for value in values):
        return None
    spans, first = [], 0
    for name, length in zip(kind.ordered_fieldnames, kind.lengths, strict=True):
        spans.append((name, first, first + length))
        first += length
    attributes = {
        **{name: _Unread(LazyMessage.decode) for name in kind.fieldnames if not hasattr(kind, name)},
        "_kind": kind,
        "_spans": tuple(spans),
        "_has_arrays": any(length > 1 for length in kind.lengths),
        "_hides_fields": any(hasattr(kind, name) for name in kind.fieldnames),
        "_message_id": message_id,
        "_type": kind.msgname,
        "_fieldnames": kind.fieldnames,
        "_instance_field": kind.instance_field,
        "_instance_offset": kind.instance_offset,
    }
    return type(kind.__name__, (LazyMessage, kind), attributes)


LAZY_KINDS: Mapping[int, type[LazyMessage]] = MappingProxyType(
    {
        message_id: lazy
        for message_id, kind in mavlink.mavlink_map.items()
        if (lazy := _lazy_kind(message_id, kind)) is not None
    }
)
"""Kinds of messages by their numbers."""
