"""How much of the service clients may take for checking plans: anybody may, and a check takes a tenth of a second."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

from aos_gcs.api.access.operators import Role
from aos_gcs.errors import AosError

MAX_PER_CLIENT: Final = 2
"""The one that is made, and the one that makes it obsolete."""
MAX_PER_ROLE: Final = 16


class TooManyChecksError(AosError):
    """A client, or all together, ask for more plans to be checked than the service has time for."""


class PlanChecks:
    """Gives turns: one check at a time for all observers, and one for all operators, who never wait for observers."""

    def __init__(self) -> None:
        self._lanes = {role: asyncio.Lock() for role in Role}
        self._asked: Counter[tuple[Role, str]] = Counter()

    @asynccontextmanager
    async def turn(self, role: Role, client: str) -> AsyncIterator[None]:
        """Wait until a plan may be checked.

        Args:
            role: of who asks.
            client: who asks, as far as that is known.

        Raises:
            TooManyChecksError: too many are waited for.
        """
        of_role = sum(count for (asking, _), count in self._asked.items() if asking is role)
        if self._asked[role, client] >= MAX_PER_CLIENT or of_role >= MAX_PER_ROLE:
            raise TooManyChecksError("Too many plans are being checked; ask again when the earlier ones are answered.")
        self._asked[role, client] += 1
        try:
            async with self._lanes[role]:
                yield
        finally:
            self._asked[role, client] -= 1
            if self._asked[role, client] == 0:
                del self._asked[role, client]
