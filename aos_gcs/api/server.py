"""The web server, inside the service's event loop."""

from __future__ import annotations

import asyncio
import errno
import socket
from collections.abc import AsyncIterator
from contextlib import AbstractContextManager, asynccontextmanager, nullcontext
from dataclasses import dataclass

import uvicorn
from fastapi import FastAPI

from aos_gcs.api.limited_protocol import limited_protocol
from aos_gcs.errors import LinkError

_LARGEST_CLIENT_MESSAGE_BYTES = 4096
_GRACE_S = 3
"""Time for requests in progress when the service ends; then they are cancelled."""


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """Address on which the service listens."""

    host: str
    port: int

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/"


class _Server(uvicorn.Server):
    """Server that leaves signals to the program that owns the loop, and reports when it listens."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self._listening = asyncio.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._listening.set()

    async def wait_until_listening(self, serving: asyncio.Task[None]) -> None:
        """Return when requests are answered, or when ``serving`` has ended before that."""
        listening = asyncio.create_task(self._listening.wait())
        await asyncio.wait({serving, listening}, return_when=asyncio.FIRST_COMPLETED)
        listening.cancel()

    def capture_signals(self) -> AbstractContextManager[None]:  # type: ignore[override]  # is a generator's there
        return nullcontext()


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
            raise LinkError(
                f"port {port} is in use: stop the other program or choose another port with --port"
            ) from error
        raise LinkError(f"cannot listen on {host} port {port}: {error.strerror or error}") from error
    # Connections inherit it. Without, the kernel holds back what follows an answer's head for some 40 ms; asyncio would
    # switch that off itself only on sockets that name their protocol.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


@asynccontextmanager
async def serve(app: FastAPI, host: str = "127.0.0.1", port: int = 8080) -> AsyncIterator[ServerAddress]:
    """Serve ``app`` for as long as the context is entered; port 0 takes a free one.

    Raises:
        LinkError: the port is in use, or the host is not an address of this machine; nothing was started.
    """
    listener = listen(host, port)
    config = uvicorn.Config(
        app,
        http=limited_protocol(app.state.limits),
        ws="websockets-sansio",
        ws_per_message_deflate=False,  # compressing each snapshot would cost the mission's loop more than the network
        ws_max_size=_LARGEST_CLIENT_MESSAGE_BYTES,
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,  # whoever connects could name any address in them, and guess codes under all of them
        timeout_graceful_shutdown=_GRACE_S,
    )
    server = _Server(config)
    with listener:
        # Not a TaskGroup: that would wrap the errors of the caller's own body into a group.
        serving = asyncio.create_task(server.serve(sockets=[listener]))
        try:
            await server.wait_until_listening(serving)
            yield ServerAddress(host, listener.getsockname()[1])
        finally:
            server.should_exit = True
            await serving
