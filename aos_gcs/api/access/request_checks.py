"""Checks that only operators, on pages of this service, send commands to vehicles.

Browsers let any web page send requests to ``127.0.0.1`` and open WebSockets to it. Two checks stop that:

- ``Host`` must be ``localhost``, an IP address or a name that was allowed: a foreign domain whose DNS entry was bound
  to our address (DNS rebinding) carries its own name there;
- ``Origin``, which browsers send with every WebSocket and every POST, must be this service. Programs without a browser
  send none and are let through: they are not under a foreign page's control.

A third check refuses requests for which the client's role is not enough, by the table of :mod:`.roles`.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from aos_gcs.api.access.operators import Access, AccessDeniedError
from aos_gcs.api.access.roles import READING, needed_role
from aos_gcs.api.errors import error_response, status_and_id

_CONTENT_SECURITY_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; worker-src 'self' blob:; style-src 'self' 'unsafe-inline'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Nothing is requested from elsewhere, and no foreign page can frame the buttons. The map needs blob workers and images
and sets styles on its elements."""

_HEADERS = [
    (b"content-security-policy", _CONTENT_SECURITY_POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
]
_POLICY_VIOLATION = 1008


@dataclass(frozen=True, slots=True)
class RequestRefusal:
    """The reason to refuse a request."""

    error_id: str
    text: str


def refusal(headers: Mapping[str, str], allowed_hosts: Collection[str], *, check_origin: bool) -> RequestRefusal | None:
    """Return the reason to refuse a request, or ``None`` for one that may pass.

    Args:
        headers: lower-case names.
        allowed_hosts: host names, without port, beside localhost and IP addresses.
        check_origin: false for plain reading, which other origins can ask for but, without CORS, not see.
    """
    host = headers.get("host", "")
    if not _is_trusted_host(host, allowed_hosts):
        return RequestRefusal(
            "unknown_host", f"The host name '{host}' is not allowed. Open the dashboard by its IP address."
        )
    origin = headers.get("origin")
    if check_origin and origin is not None and not _is_same_origin(origin, host):
        return RequestRefusal(
            "cross_origin", f"Requests from pages of '{origin}' are not allowed. Open the service's own page."
        )
    return None


def _is_trusted_host(host: str, allowed_hosts: Collection[str]) -> bool:
    try:
        parts = urlsplit(f"//{host}")
        name, _ = parts.hostname, parts.port
    except ValueError:
        return False
    if name is None:
        return False
    if name == "localhost" or name in allowed_hosts:
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _is_same_origin(origin: str, host: str) -> bool:
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in {"http", "https"} and parts.netloc.lower() == host.lower()


class SameOriginMiddleware:
    """Answers 403 to requests, and refuses WebSockets, that :func:`refusal` has a reason against."""

    def __init__(self, app: ASGIApp, allowed_hosts: Collection[str] = ()) -> None:
        self._app = app
        self._allowed_hosts = frozenset(name.lower() for name in allowed_hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then pass on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        is_websocket = scope["type"] == "websocket"
        check_origin = is_websocket or scope["method"] not in READING
        reason = refusal(Headers(scope=scope), self._allowed_hosts, check_origin=check_origin)
        if reason is None:
            await self._app(scope, receive, send)
        elif is_websocket:
            await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": reason.error_id})
        else:
            await error_response(403, reason.error_id, reason.text)(scope, receive, send)


class RolesMiddleware:
    """Refuses requests for which the client's role is not enough; routes need no check of their own."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then pass on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        needed = needed_role(scope.get("method", "GET"), scope["path"])
        try:
            self._access.check(self._access.session_of(HTTPConnection(scope)), needed)
        except AccessDeniedError as refused:
            status, error_id = status_and_id(refused)
            if scope["type"] == "websocket":
                await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": error_id})
            else:
                await error_response(status, error_id, str(refused))(scope, receive, send)
            return
        await self._app(scope, receive, send)


class SecurityHeadersMiddleware:
    """Adds the headers that confine the page to what this service delivers."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, adding headers to the answer."""

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], *_HEADERS]
            await send(message)

        await self._app(scope, receive, send_with_headers)
