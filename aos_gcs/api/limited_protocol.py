"""HTTP connections and event streams within limits: none stays without a request, none sends more than pages do."""

from __future__ import annotations

import asyncio
from typing import Any, Final

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from aos_gcs.api.access.connection_limits import AcceptedConnection, ConnectionLimits
from aos_gcs.api.access.peer_limits import ADMISSION
from aos_gcs.token_bucket import TokenBucket

FIRST_REQUEST_WITHIN_S: Final = 10.0
"""Time for the head of the first request, which browsers send at once; they also open connections in reserve."""
_STREAM_BYTES_PER_S: Final = 2048.0
_STREAM_BYTES_AT_ONCE: Final = 8192.0
"""What a page sends on its event stream: answers to pings, and holds."""


class LimitedProtocol(H11Protocol):
    """A connection that was admitted, and tells its requests by which admission.

    Args:
        admission: admission of the connection.
        limits: limits to which it counts until it is lost, or becomes an event stream.
    """

    def __init__(self, admission: AcceptedConnection, limits: ConnectionLimits, **uvicorn: Any) -> None:
        super().__init__(**uvicorn)
        self.app_state = {**self.app_state, ADMISSION: admission}
        self._admission = admission
        self._limits = limits

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self._admission.close = transport.abort
        self.loop.call_later(FIRST_REQUEST_WITHIN_S, self._close_if_idle)

    def connection_lost(self, exc: Exception | None) -> None:
        """Count no longer."""
        self._limits.leave(self._admission)
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: object) -> None:
        """Count no longer: from now on it is an event stream, which has limits of its own."""
        self._limits.leave(self._admission)
        super().handle_websocket_upgrade(event)  # type: ignore[arg-type]

    def _close_if_idle(self) -> None:
        if self._admission.is_counted and self.cycle is None:
            self.transport.abort()


class LimitedStream(WebSocketsSansIOProtocol):
    """An event stream that is closed when its client sends more than pages do."""

    def __init__(self, **uvicorn: Any) -> None:
        super().__init__(**uvicorn)
        self._budget: TokenBucket | None = None

    def data_received(self, data: bytes) -> None:
        """Pass on what is within the limit."""
        if self._budget is None:  # the request, which uvicorn hands on
            self._budget = TokenBucket(_STREAM_BYTES_PER_S, _STREAM_BYTES_AT_ONCE)
        elif not self._budget.take(len(data), self.loop.time()):
            self.transport.abort()
            return
        super().data_received(data)
