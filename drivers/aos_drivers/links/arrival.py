"""Arrival of datagrams at a socket, by the kernel."""

from __future__ import annotations

import socket
import struct
import sys
from collections.abc import Sequence

_SO_TIMESTAMPNS = 35
"""Linux: the option, and the kind of ancillary data that it adds; Python has no name for it."""
_TIME = struct.Struct("@ll")
"""Seconds and nanoseconds since the Unix epoch, as the kernel's own integers."""
ARRIVAL_BYTES = socket.CMSG_SPACE(_TIME.size)
"""Room for the ancillary data that tells an arrival."""


def ask_for_arrivals(source: socket.socket) -> None:
    """Let the kernel tell when each datagram of a socket arrived; elsewhere than on Linux it does not."""
    if sys.platform == "linux":
        source.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)


def time_in_socket_s(ancillary: Sequence[tuple[int, int, bytes]], now_utc_s: float, longest_s: float) -> float:
    """Return for how long a datagram has waited in its socket, up to ``longest_s``; 0 where that is not known.

    The machine's clock, which reads ``now_utc_s``, may be set meanwhile: hence never less than 0, nor more than there
    is reason to wait.
    """
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == _SO_TIMESTAMPNS and len(data) == _TIME.size:
            seconds, nanoseconds = _TIME.unpack(data)
            time_s: float = now_utc_s - seconds - nanoseconds * 1e-9
            return min(max(0.0, time_s), longest_s)
    return 0.0
