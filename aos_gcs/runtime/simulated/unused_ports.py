"""Ports of this machine for a link or a page that this process opens a moment later."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator

_PORTS = range(20_000, 32_000, 2)
"""Ports below those that Linux, macOS and Windows give to sockets that ask for any, so none of these takes one that was
only found, and not opened yet. They are even, as the port after the one of RTP belongs to RTCP."""
_STRIDE = 499
"""Ports between the first one of a process and that of the process started after it."""


def unused_ports(kind: socket.SocketKind) -> Iterator[int]:
    """Yield ports of 127.0.0.1 that nobody has open, each once.

    Two processes begin at different ports, by their identifiers.

    Args:
        kind: ``socket.SOCK_DGRAM`` for UDP, ``socket.SOCK_STREAM`` for TCP.
    """
    first = os.getpid() * _STRIDE
    for index in range(len(_PORTS)):
        port = _PORTS[(first + index) % len(_PORTS)]
        with socket.socket(socket.AF_INET, kind) as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:  # in use, or kept by the system
                continue
        yield port
