"""MAVLink FTP, which the simulated autopilots do not have: every request is refused, so that nobody waits for files."""

from __future__ import annotations

import struct

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_HEADER = struct.Struct("<HBBBBBxI")
"""Sequence number, session, operation, size of the data, operation answered, burst flag, offset."""
_PAYLOAD_BYTES = 251
_NAK = 129
_UNKNOWN_COMMAND = 7


def refusal(request: mavlink.MAVLink_file_transfer_protocol_message) -> mavlink.MAVLink_message:
    """Return the answer to a request: that its operation is not known."""
    sequence, session, operation, *_ = _HEADER.unpack(bytes(request.payload[: _HEADER.size]))
    header = _HEADER.pack((sequence + 1) % 65536, session, _NAK, 1, operation, 0, 0)
    payload = (header + bytes([_UNKNOWN_COMMAND])).ljust(_PAYLOAD_BYTES, b"\0")
    return mavlink.MAVLink_file_transfer_protocol_message(
        0, request.get_srcSystem(), request.get_srcComponent(), list(payload)
    )
