"""Cutting MAVLink packets out of a stream of bytes."""

from __future__ import annotations

import binascii
import re

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_MARKER = re.compile(rb"[\xfd\xfe]")
_HEADER_SIZE = {mavlink.PROTOCOL_MARKER_V1: 6, mavlink.PROTOCOL_MARKER_V2: 10}
_CRC_SIZE = 2
_CRC_START = 0xFFFF
_REVERSED_BITS = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


class FrameParser:
    """Parser of the bytes of one peer.

    Unlike pymavlink's own, it looks for the next marker inside a packet that turns out to be broken, so that noise
    never takes a good packet with it. At most one incomplete packet (305 bytes) is kept between calls.
    """

    def __init__(self) -> None:
        self._decoder = mavlink.MAVLink(None)
        self._tail = b""
        self.dropped_bytes = 0
        """Bytes that belonged to no valid packet."""

    def feed(self, data: bytes) -> list[mavlink.MAVLink_message]:
        """Return the packets that ``data`` completes; anything else is dropped and counted."""
        data = self._tail + data
        messages: list[mavlink.MAVLink_message] = []
        index = 0
        while match := _MARKER.search(data, index):
            start = match.start()
            self.dropped_bytes += start - index
            index = start
            end = _frame_end(data, start)
            if end is None or end > len(data):
                self._tail = data[start:]
                return messages
            message = self._decode(data, start, end)
            if message is None:
                self.dropped_bytes += 1
                index = start + 1
            else:
                messages.append(message)
                index = end
        self.dropped_bytes += len(data) - index
        self._tail = b""
        return messages

    def _decode(self, data: bytes, start: int, end: int) -> mavlink.MAVLink_message | None:
        if data[start] == mavlink.PROTOCOL_MARKER_V2 and data[start + 2] & ~mavlink.MAVLINK_IFLAG_SIGNED:
            return None
        message_id = _message_id(data, start)
        kind = mavlink.mavlink_map.get(message_id)
        if kind is not None and not (
            _has_credible_length(data, start, kind) and _is_intact(data, start, end, kind.crc_extra)
        ):
            return None
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


def _message_id(data: bytes, start: int) -> int:
    if data[start] == mavlink.PROTOCOL_MARKER_V1:
        return data[start + 5]
    return int.from_bytes(data[start + 7 : start + 10], "little")


def _has_credible_length(data: bytes, start: int, kind: type[mavlink.MAVLink_message]) -> bool:
    """Return whether MAVLink 1 can have a message of that length; MAVLink 2 cuts and extends messages."""
    return data[start] == mavlink.PROTOCOL_MARKER_V2 or bool(data[start + 1] <= kind.unpacker.size)


def _is_intact(data: bytes, start: int, end: int, crc_extra: int) -> bool:
    """Return whether the checksum of a packet is right.

    It is computed in C, unlike pymavlink's: whoever reaches the port can send any number of packets that only seem to
    be some. The library has the checksum of X.25 with the bits the other way round.
    """
    stop = end - (mavlink.MAVLINK_SIGNATURE_BLOCK_LEN if is_signed(data, start) else 0) - _CRC_SIZE
    covered = data[start + 1 : stop] + bytes((crc_extra,))
    low, high = (
        binascii.crc_hqx(covered.translate(_REVERSED_BITS), _CRC_START).to_bytes(2, "big").translate(_REVERSED_BITS)
    )
    return data[stop] == low and data[stop + 1] == high


def _fill_in_sender(message: mavlink.MAVLink_unknown) -> None:
    """Fill in the sender of a message of a newer dialect, which pymavlink leaves out."""
    packet, header = message.get_msgbuf(), message.get_header()
    start = 4 if packet[0] == mavlink.PROTOCOL_MARKER_V2 else 2
    header.seq, header.srcSystem, header.srcComponent = packet[start : start + 3]


def is_signed(data: bytes | bytearray, start: int = 0) -> bool:
    """Whether the packet at ``start``, of three bytes or more, says that a signature ends it."""
    return data[start] == mavlink.PROTOCOL_MARKER_V2 and bool(data[start + 2] & mavlink.MAVLINK_IFLAG_SIGNED)


def without_signature(message: mavlink.MAVLink_message) -> bytes:
    """Return the packet without its signature, which differs from link to link."""
    packet = bytes(message.get_msgbuf())
    return packet[: -mavlink.MAVLINK_SIGNATURE_BLOCK_LEN] if is_signed(packet) else packet


def _frame_end(data: bytes, start: int) -> int | None:
    """Return where the packet at ``start`` ends, or None while its header is incomplete."""
    if len(data) < start + 3:
        return None
    end = start + _HEADER_SIZE[data[start]] + data[start + 1] + _CRC_SIZE
    if is_signed(data, start):
        end += mavlink.MAVLINK_SIGNATURE_BLOCK_LEN
    return end
