"""Cutting MAVLink packets out of a stream of bytes."""

from __future__ import annotations

import binascii
import re

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.packet import LAZY_KINDS

_MARKER = re.compile(rb"[\xfd\xfe]")
_V2, _SIGNED, _SIGNATURE_SIZE = (
    mavlink.PROTOCOL_MARKER_V2,
    mavlink.MAVLINK_IFLAG_SIGNED,
    mavlink.MAVLINK_SIGNATURE_BLOCK_LEN,
)
_UNKNOWN_FLAGS = 0xFF & ~_SIGNED
_HEADER_SIZE = {mavlink.PROTOCOL_MARKER_V1: 6, mavlink.PROTOCOL_MARKER_V2: 10}
_LENGTH_SIZE = 3
"""Bytes of a header that tell how long the packet is."""
_CRC_SIZE = 2
_CRC_START = 0xFFFF
_REVERSED_BITS = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_KINDS = {
    message_id: (kind.unpacker.size, bytes([kind.crc_extra]), LAZY_KINDS.get(message_id))
    for message_id, kind in mavlink.mavlink_map.items()
}
"""Size of the payload of each kind of message, the byte that its checksum ends with, and how it is read."""


class FrameParser:
    """Parser of the bytes of one peer.

    Unlike pymavlink's own, it looks for the next marker inside a packet that turns out to be broken, so that noise
    never takes a good packet with it. At most one incomplete packet (305 bytes) is kept between calls.
    """

    __slots__ = ("_decoder", "_tail", "dropped_bytes")

    def __init__(self) -> None:
        self._decoder = mavlink.MAVLink(None)
        self._tail = b""
        self.dropped_bytes = 0
        """Bytes that belonged to no valid packet."""

    def feed(self, data: bytes) -> list[mavlink.MAVLink_message]:
        """Return the packets that ``data`` completes; anything else is dropped and counted."""
        if self._tail:
            data = self._tail + data
            self._tail = b""
        messages: list[mavlink.MAVLink_message] = []
        index, size = 0, len(data)
        while index < size:
            marker = data[index]
            header_size = _HEADER_SIZE.get(marker)
            if header_size is None:
                match = _MARKER.search(data, index)
                start = match.start() if match else size
                self.dropped_bytes += start - index
                index = start
                continue
            if size < index + _LENGTH_SIZE:
                self._tail = data[index:]
                break
            stop = index + header_size + data[index + 1]
            end = stop + _CRC_SIZE
            if data[index + 2] & _SIGNED and marker == _V2:
                end += _SIGNATURE_SIZE
            if end > size:
                self._tail = data[index:]
                break
            message = self._decode(data, index, stop, end)
            if message is None:
                self.dropped_bytes += 1
                index += 1
            else:
                messages.append(message)
                index = end
        return messages

    def _decode(self, data: bytes, start: int, stop: int, end: int) -> mavlink.MAVLink_message | None:
        """Return the message of a packet whose payload ends at ``stop``; None if there is no packet at ``start``."""
        is_v2 = data[start] == _V2
        if is_v2 and data[start + 2] & _UNKNOWN_FLAGS:
            return None
        message_id = data[start + 7] | data[start + 8] << 8 | data[start + 9] << 16 if is_v2 else data[start + 5]
        known = _KINDS.get(message_id)
        if known is not None:
            size, extra, lazy_kind = known
            # MAVLink 2 cuts and extends messages, MAVLink 1 cannot have longer ones.
            if not ((is_v2 or data[start + 1] <= size) and _is_intact(data, start, stop, extra)):
                return None
            if lazy_kind is not None:
                return lazy_kind(data[start:end])
        try:
            message = self._decoder.decode(bytearray(data[start:end]))
        except mavlink.MAVError:
            return None
        # The checksum of an unknown message cannot be tested; a marker behind it shows that its length was true.
        if isinstance(message, mavlink.MAVLink_unknown):
            if end < len(data) and data[end] not in _HEADER_SIZE:
                return None
            _fill_in_sender(message)
        return message


def _is_intact(data: bytes, start: int, stop: int, extra: bytes) -> bool:
    """Return whether the checksum at ``stop`` is right.

    It is computed in C, unlike pymavlink's: whoever reaches the port can send any number of packets that only seem to
    be some. The library has the checksum of X.25 with the bits the other way round.
    """
    checksum = binascii.crc_hqx((data[start + 1 : stop] + extra).translate(_REVERSED_BITS), _CRC_START)
    return data[stop] == _REVERSED_BITS[checksum >> 8] and data[stop + 1] == _REVERSED_BITS[checksum & 0xFF]


def _fill_in_sender(message: mavlink.MAVLink_unknown) -> None:
    """Fill in the sender of a message of a newer dialect, which pymavlink leaves out."""
    packet, header = message.get_msgbuf(), message.get_header()
    start = 4 if packet[0] == mavlink.PROTOCOL_MARKER_V2 else 2
    header.seq, header.srcSystem, header.srcComponent = packet[start : start + 3]


def is_signed(data: bytes | bytearray) -> bool:
    """Whether a packet, of three bytes or more, says that a signature ends it."""
    return bool(data[0] == _V2 and data[2] & _SIGNED != 0)


def without_signature(message: mavlink.MAVLink_message) -> bytes:
    """Return the packet without its signature, which differs from link to link."""
    packet = bytes(message.get_msgbuf())
    return packet[:-_SIGNATURE_SIZE] if is_signed(packet) else packet
