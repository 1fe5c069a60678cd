"""The socket on which the server listens. Nothing of a web framework is imported here, which takes its time."""

from __future__ import annotations

import errno
import socket
from dataclasses import dataclass

from aos_gcs.api.port_holder import find_holder
from aos_gcs.errors import LinkError


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """Address on which the service listens."""

    host: str
    port: int
    is_encrypted: bool = False

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'https' if self.is_encrypted else 'http'}://{host}:{self.port}/"


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 takes a free one.

    Raises:
        LinkError: the port is in use, or the host is not an address of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            holder = find_holder(port)
            by = ": stop the other program" if holder is None else f" by {holder.describe()}"
            raise LinkError(f"port {port} is in use{by} or choose another port with --port") from error
        raise LinkError(f"cannot listen on {host} port {port}: {error.strerror or error}") from error
    # Connections inherit it. Without, the kernel holds back what follows an answer's head for some 40 ms; asyncio would
    # switch that off itself only on sockets that name their protocol.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener
