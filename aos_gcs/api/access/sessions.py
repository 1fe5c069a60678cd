"""The session of a client: its role and its name."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.api.access.roles import Role


@dataclass(frozen=True, slots=True)
class Session:
    """Role and name of a client."""

    role: Role
    name: str
    """Name of the account, or the one given at sign-in with the code; empty for those who have not signed in."""
