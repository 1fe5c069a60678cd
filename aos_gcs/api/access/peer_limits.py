"""Limits for each client address, so that observers and strangers do not keep the service from its operators.

Addresses from which operators have signed in are known, and the total does not count for them. IPv6 clients are
counted by network, since one machine may use any address in it.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable
from http import HTTPStatus
from typing import Final

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from aos_gcs.api.access.guess_throttle import group_of
from aos_gcs.api.access.operators import Access, Role
from aos_gcs.api.errors import error_response
from aos_gcs.token_bucket import TokenBucket

CONNECTIONS_PER_PEER: Final = 64
"""Several browsers on one machine, each of which opens six."""
CONNECTIONS_IN_ALL: Final = 512
"""Connections of addresses without an operator."""
FOLLOWERS_PER_PEER: Final = 32
FOLLOWERS_IN_ALL: Final = 128
"""Event streams of observers; each costs the service some work with every change."""
REQUESTS_PER_S: Final = 100.0
BURST: Final = 500.0
"""Requests that an address may send at once: a page with a map of tiles sends hundreds."""
PEERS_KEPT: Final = 4096
_TRY_LATER: Final = 1013


class PeerLimits:
    """Counts connections, event streams and requests per address.

    Args:
        now_s: clock in real seconds.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._budgets: OrderedDict[str, TokenBucket] = OrderedDict()
        self._followers: Counter[str] = Counter()
        self._connections: Counter[str] = Counter()
        self._known: OrderedDict[str, None] = OrderedDict()

    def know(self, address: str) -> None:
        """Note that an operator is at this address."""
        self._known[group_of(address)] = None
        if len(self._known) > PEERS_KEPT:
            self._known.popitem(last=False)

    def take_request(self, address: str) -> bool:
        """Return whether an address may send a request now, and count it."""
        now_s, peer = self._now_s(), group_of(address)
        budget = self._budgets.pop(peer, None) or TokenBucket(REQUESTS_PER_S, BURST)
        self._budgets[peer] = budget
        if len(self._budgets) > PEERS_KEPT:
            self._budgets.popitem(last=False)
        return budget.take(1.0, now_s)

    def begin_following(self, address: str) -> bool:
        """Return whether an address may follow the events once more, and count it until ``end_following``."""
        return self._begin(self._followers, address, FOLLOWERS_PER_PEER, FOLLOWERS_IN_ALL)

    def end_following(self, address: str) -> None:
        """Count one event stream less."""
        _end(self._followers, address)

    def begin_connection(self, address: str) -> bool:
        """Return whether an address may open another connection, and count it until ``end_connection``."""
        return self._begin(self._connections, address, CONNECTIONS_PER_PEER, CONNECTIONS_IN_ALL)

    def end_connection(self, address: str) -> None:
        """Count one connection less."""
        _end(self._connections, address)

    def _begin(self, counts: Counter[str], address: str, most_per_peer: int, most: int) -> bool:
        peer = group_of(address)
        is_full = counts[peer] >= most_per_peer or (peer not in self._known and counts.total() >= most)
        if not is_full:
            counts[peer] += 1
        elif not counts[peer]:
            del counts[peer]
        return not is_full


def _end(counts: Counter[str], address: str) -> None:
    peer = group_of(address)
    counts[peer] -= 1
    if counts[peer] <= 0:
        del counts[peer]


class PeerLimitMiddleware:
    """Refuses requests beyond the limits before anything else looks at them; operators have none."""

    def __init__(self, app: ASGIApp, limits: PeerLimits, access: Access) -> None:
        self._app = app
        self._limits = limits
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then pass on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        address = scope["client"][0] if scope.get("client") else ""
        is_operator = self._access.is_required and self._is_operator(scope)
        if is_operator:
            self._limits.know(address)
        if scope["type"] == "websocket":
            await self._follow(address, is_operator, scope, receive, send)
        elif is_operator or self._limits.take_request(address):
            await self._app(scope, receive, send)
        else:
            text = "Too many requests from this address. Try again in a few seconds."
            await error_response(HTTPStatus.TOO_MANY_REQUESTS, "too_many_requests", text)(scope, receive, send)

    async def _follow(self, address: str, is_operator: bool, scope: Scope, receive: Receive, send: Send) -> None:
        if is_operator:
            await self._app(scope, receive, send)
        elif not self._limits.begin_following(address):
            await send({"type": "websocket.close", "code": _TRY_LATER, "reason": "too many event streams"})
        else:
            try:
                await self._app(scope, receive, send)
            finally:
                self._limits.end_following(address)

    def _is_operator(self, scope: Scope) -> bool:
        try:
            return self._access.session_of(HTTPConnection(scope)).role is Role.OPERATOR
        except ValueError:  # a malformed host
            return False
