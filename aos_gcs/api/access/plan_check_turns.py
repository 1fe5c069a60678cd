"""Limits on plan checks, which every client may request and which take a tenth of a second each."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

from aos_gcs.api.access.roles import Role
from aos_gcs.errors import AosError

MAX_PER_CLIENT: Final = 2
"""One in progress, and the one that replaces it."""
MAX_PER_ROLE: Final = 16


class TooManyChecksError(AosError):
    """Too many plan checks are pending, of one client or of all together."""


class PlanChecks:
    """Queue of plan checks: one at a time for observers and one for operators, who never wait for observers."""

    def __init__(self) -> None:
        self._lanes = {role: asyncio.Lock() for role in Role}
        self._asked: Counter[tuple[Role, str]] = Counter()

    @asynccontextmanager
    async def turn(self, role: Role, client: str) -> AsyncIterator[None]:
        """Wait until a plan may be checked.

        Args:
            role: role of the client.
            client: identity of the client, as far as it is known.

        Raises:
            TooManyChecksError: too many checks are pending.
        """
        of_role = sum(count for (asking, _), count in self._asked.items() if asking is role)
        if self._asked[role, client] >= MAX_PER_CLIENT or of_role >= MAX_PER_ROLE:
            raise TooManyChecksError("Too many plan checks are pending. Try again when the earlier ones are complete.")
        self._asked[role, client] += 1
        try:
            async with self._lanes[role]:
                yield
        finally:
            self._asked[role, client] -= 1
            if self._asked[role, client] == 0:
                del self._asked[role, client]
