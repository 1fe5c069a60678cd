"""Messages between a process and its worker: bytes behind their length, on a socket."""

from __future__ import annotations

import socket
import struct

_LENGTH = struct.Struct("!Q")


def send(control: socket.socket, message: bytes) -> None:
    """Send a message."""
    control.sendall(_LENGTH.pack(len(message)))
    control.sendall(message)


def receive(control: socket.socket, max_bytes: int | None = None) -> bytes | None:
    """Return the next message; None when the other side has gone.

    Raises:
        ValueError: it is longer than allowed.
    """
    head = _exactly(control, _LENGTH.size)
    if head is None:
        return None
    (length,) = _LENGTH.unpack(head)
    if max_bytes is not None and length > max_bytes:
        raise ValueError(f"a message of {length} bytes, more than {max_bytes}")
    return _exactly(control, length)


def _exactly(control: socket.socket, size: int) -> bytes | None:
    data = bytearray()
    while len(data) < size:
        try:
            part = control.recv(min(size - len(data), 1 << 20))
        except ConnectionError:
            return None
        if not part:
            return None
        data += part
    return bytes(data)
