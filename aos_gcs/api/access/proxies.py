"""Proxies in front of the service: what they say about clients is believed from configured addresses only."""

from __future__ import annotations

import ipaddress
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

_SCHEMES: Final = {
    ("http", "https"): "https",
    ("http", "http"): "http",
    ("websocket", "https"): "wss",
    ("websocket", "http"): "ws",
}


class TrustedProxies:
    """Addresses of proxies.

    Args:
        networks: addresses, or networks such as ``10.0.0.0/24``.

    Raises:
        ValueError: one is neither.
    """

    def __init__(self, networks: Sequence[str]) -> None:
        self._networks = [ipaddress.ip_network(one) for one in networks]

    def __contains__(self, address: object) -> bool:
        return bool(self._networks) and _is_within(str(address), tuple(self._networks))

    def client(self, peer: str, forwarded_for: str) -> str:
        """Return the client's address: the last one in the header that is no proxy, or else the peer's."""
        for part in reversed(forwarded_for.split(",")):
            try:
                address = str(ipaddress.ip_address(part.strip()))
            except ValueError:
                break
            if address not in self:
                return address
        return peer


@lru_cache(maxsize=1024)
def _is_within(address: str, networks: tuple[ipaddress.IPv4Network | ipaddress.IPv6Network, ...]) -> bool:
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return False
    mapped = getattr(parsed, "ipv4_mapped", None) or parsed
    return any(mapped in network for network in networks)


class ProxyMiddleware:
    """Takes address and encryption of clients from the headers of trusted proxies; those of others are ignored."""

    def __init__(self, app: ASGIApp, proxies: TrustedProxies) -> None:
        self._app = app
        self._proxies = proxies

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Replace, then pass on."""
        client = scope.get("client")
        if scope["type"] in {"http", "websocket"} and client and client[0] in self._proxies:
            headers = Headers(scope=scope)
            address = self._proxies.client(client[0], ",".join(headers.getlist("x-forwarded-for")))
            told = headers.get("x-forwarded-proto", "").strip().lower()
            scheme = _SCHEMES.get((scope["type"], told), scope.get("scheme", "http"))
            scope = {**scope, "client": (address, client[1]), "scheme": scheme}
        await self._app(scope, receive, send)
