"""Roles and sessions of clients, and the one table that says which role each request needs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from types import MappingProxyType
from typing import Final


class Role(StrEnum):
    """Role of a client, the least first: each may do all that the ones before it may."""

    VISITOR = "visitor"
    """Has not signed in where everybody has an account: sees the page's files and the sign-in."""
    OBSERVER = "observer"
    """Sees everything and changes nothing."""
    ANALYST = "analyst"
    """Marks and judges findings; never commands vehicles."""
    OPERATOR = "operator"
    """Flies."""
    ADMINISTRATOR = "administrator"
    """Also manages accounts."""

    def may(self, needed: Role) -> bool:
        """Return whether this role includes another one."""
        return _RANKS[self] >= _RANKS[needed]


@dataclass(frozen=True, slots=True)
class Session:
    """Role and name of a client."""

    role: Role
    name: str
    """Name of the account, or the one given at sign-in with the code; empty for those who have not signed in."""


_RANKS: Final = {role: rank for rank, role in enumerate(Role)}

READING: Final = frozenset({"GET", "HEAD"})
_EVERYBODY, _ANALYST, _OPERATOR, _ADMINISTRATOR = Role.VISITOR, Role.ANALYST, Role.OPERATOR, Role.ADMINISTRATOR

ROUTE_ROLES: Final[Mapping[tuple[str, str], Role]] = MappingProxyType(
    {
        ("GET", "/api/session"): _EVERYBODY,
        ("POST", "/api/session"): _EVERYBODY,
        ("DELETE", "/api/session"): _EVERYBODY,
        ("POST", "/api/session/invitation"): _EVERYBODY,
        ("POST", "/api/session/password"): Role.OBSERVER,
        ("POST", "/api/plan/check"): Role.OBSERVER,
        ("POST", "/api/plan/import"): _OPERATOR,
        ("PUT", "/api/plans/{name:path}"): _OPERATOR,
        ("DELETE", "/api/plans/{name:path}"): _OPERATOR,
        ("POST", "/api/plan/apply"): _OPERATOR,
        ("POST", "/api/proposals/{proposal_id}"): _OPERATOR,
        ("POST", "/api/findings"): _ANALYST,
        ("PATCH", "/api/findings/{finding_id}"): _ANALYST,
        ("POST", "/api/wall/video"): _ANALYST,
        ("DELETE", "/api/wall/video"): _ANALYST,
        ("POST", "/api/notices/acknowledge"): _OPERATOR,
        ("POST", "/api/preflight/override"): _OPERATOR,
        ("POST", "/api/mission/actions"): _OPERATOR,
        ("POST", "/api/control/request"): _OPERATOR,
        ("POST", "/api/control/answer"): _OPERATOR,
        ("POST", "/api/control/take"): _OPERATOR,
        ("POST", "/api/control/release"): _OPERATOR,
        ("POST", "/api/replay"): _OPERATOR,
        ("GET", "/api/accounts"): _ADMINISTRATOR,
        ("GET", "/api/accounts/sign-ins"): _ADMINISTRATOR,
        ("POST", "/api/accounts/invitations"): _ADMINISTRATOR,
        ("PATCH", "/api/accounts/{name}"): _ADMINISTRATOR,
        ("DELETE", "/api/accounts/{name}"): _ADMINISTRATOR,
    }
)
"""Least role by method and path, for all routes that change something and for those that not every observer may read.
Whatever reads and is not named here is for observers; whatever else is not named is for operators."""

_ACCOUNTS: Final = "/api/accounts"
_API: Final = "/api/"


def needed_role(method: str, path: str) -> Role:
    """Return the least role for a request; ``method`` is ``GET`` for WebSockets."""
    reads = method in READING
    for pattern, role in _patterns().get("GET" if reads else method, ()):
        if pattern.fullmatch(path):
            return role
    if path.startswith(_ACCOUNTS):
        return Role.ADMINISTRATOR
    if not reads:
        return Role.OPERATOR
    return Role.OBSERVER if path.startswith(_API) else Role.VISITOR


@cache
def _patterns() -> Mapping[str, tuple[tuple[re.Pattern[str], Role], ...]]:
    """Return what the paths of each method look like, by the placeholders of routes."""
    found: dict[str, list[tuple[re.Pattern[str], Role]]] = {}
    for (method, path), role in ROUTE_ROLES.items():
        escaped = re.sub(r"\\\{\w+:path\\\}", ".*", re.escape(path))
        found.setdefault(method, []).append((re.compile(re.sub(r"\\\{\w+\\\}", "[^/]+", escaped), re.DOTALL), role))
    return {method: tuple(entries) for method, entries in found.items()}
