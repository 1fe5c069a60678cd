"""The web server, inside the running event loop."""

from __future__ import annotations

import asyncio
import socket
import ssl
from collections.abc import AsyncIterator
from contextlib import AbstractContextManager, asynccontextmanager, nullcontext

import uvicorn
from fastapi import FastAPI

from aos_gcs.api.acceptor import Acceptor
from aos_gcs.api.access.connection_limits import AcceptedConnection, ConnectionLimits
from aos_gcs.api.limited_protocol import LimitedProtocol, LimitedStream
from aos_gcs.api.listener import ServerAddress, listen

_LARGEST_CLIENT_MESSAGE_BYTES = 4096
_GRACE_S = 3
"""Time for requests in progress when the service ends; then they are cancelled."""


class _Server(uvicorn.Server):
    """Server that limits connections, leaves signals to the program that owns the loop, and reports when it listens."""

    def __init__(self, config: uvicorn.Config, limits: ConnectionLimits, tls: ssl.SSLContext | None) -> None:
        super().__init__(config)
        self._limits = limits
        self._tls = tls
        self._listening = asyncio.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup([])
        for listener in sockets or []:
            # It has of asyncio's servers what uvicorn calls.
            self.servers.append(Acceptor(listener, self._limits, self._make_protocol, self._tls))  # type: ignore[arg-type]
        self._listening.set()

    def _make_protocol(self, admission: AcceptedConnection) -> asyncio.Protocol:
        state, app_state = self.server_state, self.lifespan.state
        return LimitedProtocol(admission, self._limits, config=self.config, server_state=state, app_state=app_state)

    async def wait_until_listening(self, serving: asyncio.Task[None]) -> None:
        """Return when requests are answered, or when ``serving`` has ended before that."""
        listening = asyncio.create_task(self._listening.wait())
        await asyncio.wait({serving, listening}, return_when=asyncio.FIRST_COMPLETED)
        listening.cancel()

    def capture_signals(self) -> AbstractContextManager[None]:  # type: ignore[override]  # is a generator's there
        return nullcontext()


@asynccontextmanager
async def serve(
    app: FastAPI, host: str = "127.0.0.1", port: int = 8080, tls: ssl.SSLContext | None = None
) -> AsyncIterator[ServerAddress]:
    """Serve ``app`` for as long as the context is entered; port 0 takes a free one.

    Raises:
        LinkError: the port is in use, or the host is not an address of this machine; nothing was started.
    """
    with listen(host, port) as listener:
        async with serve_on(app, listener, tls):
            yield ServerAddress(host, listener.getsockname()[1], tls is not None)


@asynccontextmanager
async def serve_on(app: FastAPI, listener: socket.socket, tls: ssl.SSLContext | None = None) -> AsyncIterator[None]:
    """Serve ``app`` on a socket that listens for as long as the context is entered; with ``tls`` encrypted."""
    config = uvicorn.Config(
        app,
        ws=LimitedStream,
        ws_per_message_deflate=False,  # compressing each snapshot would cost more than the network
        ws_max_size=_LARGEST_CLIENT_MESSAGE_BYTES,
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,  # the application believes those of configured proxies only
        timeout_graceful_shutdown=_GRACE_S,
    )
    server = _Server(config, app.state.limits.connections, tls)
    # Not a TaskGroup: that would wrap the errors of the caller's own body into a group.
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        await server.wait_until_listening(serving)
        yield
    finally:
        server.should_exit = True
        await serving
