"""HTTP connections, as many as each address may have, and none that stays without a request."""

from __future__ import annotations

import asyncio
from typing import Final

from uvicorn.protocols.http.h11_impl import H11Protocol

from aos_gcs.api.access.peer_limits import PeerLimits

FIRST_REQUEST_WITHIN_S: Final = 10.0
"""Time for the head of the first request, which browsers send at once; they also open connections in reserve."""


def limited_protocol(limits: PeerLimits) -> type[H11Protocol]:
    """Return a class of connections that counts them in ``limits``."""

    class LimitedProtocol(H11Protocol):
        """A connection that is closed at once if its address has too many."""

        _address: str | None = None

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            address = self.client[0] if self.client else ""
            if not limits.begin_connection(address):
                transport.abort()
                return
            self._address = address
            self.loop.call_later(FIRST_REQUEST_WITHIN_S, self._close_if_idle)

        def connection_lost(self, exc: Exception | None) -> None:
            self._forget()
            super().connection_lost(exc)

        def handle_websocket_upgrade(self, event: object) -> None:
            # From now on it is an event stream, which has limits of its own.
            self._forget()
            super().handle_websocket_upgrade(event)  # type: ignore[arg-type]

        def _forget(self) -> None:
            address, self._address = self._address, None
            if address is not None:
                limits.end_connection(address)

        def _close_if_idle(self) -> None:
            if self._address is not None and self.cycle is None:
                self.transport.abort()

    return LimitedProtocol
