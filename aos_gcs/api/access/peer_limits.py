"""Limits for each client address, so that observers and strangers do not keep the service from its operators.

Addresses from which operators have sent requests are known, and the totals do not count for them. IPv6 clients are
counted by network, since one machine may use any address in it. Requests of others begin a few at a time, so that
those of operators never wait behind many.
"""

from __future__ import annotations

import asyncio
from collections import Counter, OrderedDict
from collections.abc import Callable, Container, Iterable
from enum import Enum, auto
from http import HTTPStatus
from typing import Final

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from aos_gcs.api.access.connection_limits import PEERS_KEPT, AcceptedConnection, ConnectionLimits
from aos_gcs.api.access.guess_throttle import group_of
from aos_gcs.api.access.operators import Access
from aos_gcs.api.access.roles import Role
from aos_gcs.api.access.turns import Turns
from aos_gcs.api.errors import error_response
from aos_gcs.token_bucket import TokenBucket

FOLLOWERS_PER_PEER: Final = 32
FOLLOWERS_IN_ALL: Final = 128
"""Event streams of observers, and as many viewers of the wall; each costs the service some work with every change."""
REQUESTS_PER_S: Final = 100.0
BURST: Final = 500.0
"""Requests that an address may send at once: a page with a map of tiles sends hundreds."""
WALL_PATH: Final = "/api/wall"
ADMISSION: Final = "admission"
"""Name under which the state of a request has the admission of its connection."""
_TRY_LATER: Final = 1013


class WebSocketKind(Enum):
    """WebSockets of the service, each with limits of its own: a page that watches the wall has one of both."""

    EVENTS = auto()
    WALL = auto()


class PeerLimits:
    """Counts connections, event streams and requests per address.

    Args:
        now_s: clock in real seconds.
        known: addresses of operators.
        exempt: addresses of proxies, whose connections are not counted.
    """

    def __init__(self, now_s: Callable[[], float], known: Iterable[str] = (), exempt: Container[str] = ()) -> None:
        self._now_s = now_s
        self._budgets: OrderedDict[str, TokenBucket] = OrderedDict()
        self._followers = {stream: Counter[str]() for stream in WebSocketKind}
        self.connections = ConnectionLimits(now_s, exempt)
        for address in known:
            self.connections.know(address)

    def take_request(self, address: str) -> bool:
        """Return whether an address may send a request now, and count it."""
        now_s, peer = self._now_s(), group_of(address)
        budget = self._budgets.pop(peer, None) or TokenBucket(REQUESTS_PER_S, BURST)
        self._budgets[peer] = budget
        if len(self._budgets) > PEERS_KEPT:
            self._budgets.popitem(last=False)
        return budget.take(1.0, now_s)

    def begin_following(self, address: str, stream: WebSocketKind = WebSocketKind.EVENTS) -> bool:
        """Return whether an address may follow a stream once more, and count it until ``end_following``."""
        peer, followers = group_of(address), self._followers[stream]
        if followers[peer] >= FOLLOWERS_PER_PEER:
            return False
        if not self.connections.is_known(address) and followers.total() >= FOLLOWERS_IN_ALL:
            return False
        followers[peer] += 1
        return True

    def end_following(self, address: str, stream: WebSocketKind = WebSocketKind.EVENTS) -> None:
        """Count one stream less."""
        peer, followers = group_of(address), self._followers[stream]
        followers[peer] -= 1
        if followers[peer] <= 0:
            del followers[peer]


class PeerLimitMiddleware:
    """Refuses requests beyond the limits before anything else looks at them; operators have none."""

    def __init__(self, app: ASGIApp, limits: PeerLimits, access: Access) -> None:
        self._app = app
        self._limits = limits
        self._access = access
        self._turns = Turns()
        self._writing: set[asyncio.Task[None]] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then pass on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        address = scope["client"][0] if scope.get("client") else ""
        admission: AcceptedConnection | None = scope.get("state", {}).get(ADMISSION)
        if self._access.is_required and self._is_operator(scope):
            self._know(address)
            if admission is not None:
                self._limits.connections.trust(admission)
            await self._app(scope, receive, send)
        elif admission is not None and admission.is_on_probation:
            await _refuse("too_many_connections", "Too many connections from this address.", scope, receive, send)
        else:
            await self._turns.wait()
            await self._pass_on(address, scope, receive, send)

    def _know(self, address: str) -> None:
        """Note that an operator is at this address, also for a process that replaces this one, without waiting."""
        self._limits.connections.know(address)
        if self._access.note_address(address):
            task = asyncio.get_running_loop().create_task(self._access.write_down())
            self._writing.add(task)
            task.add_done_callback(self._writing.discard)

    async def _pass_on(self, address: str, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what is no operator's, within the limits."""
        if scope["type"] == "websocket":
            stream = WebSocketKind.WALL if scope["path"] == WALL_PATH else WebSocketKind.EVENTS
            if not self._limits.begin_following(address, stream):
                await _refuse("too_many_streams", "", scope, receive, send)
                return
            try:
                await self._app(scope, receive, send)
            finally:
                self._limits.end_following(address, stream)
        elif self._limits.take_request(address):
            await self._app(scope, receive, send)
        else:
            await _refuse("too_many_requests", "Too many requests from this address.", scope, receive, send)

    def _is_operator(self, scope: Scope) -> bool:
        try:
            return self._access.session_of(HTTPConnection(scope)).role.may(Role.OPERATOR)
        except ValueError:  # a malformed host
            return False


async def _refuse(error_id: str, text: str, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer what is beyond the limits, and close its connection."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": _TRY_LATER, "reason": error_id})
        return
    response = error_response(HTTPStatus.TOO_MANY_REQUESTS, error_id, f"{text} Try again in a few seconds.")
    response.headers["Connection"] = "close"
    await response(scope, receive, send)
