"""Requests that begin a few at a time, so that the event loop comes round to others in between."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Final

BEGUN_PER_ROUND: Final = 2
"""Requests that begin in one round of the event loop: each takes it one to two milliseconds."""


class Turns:
    """Lets requests begin in the order of their arrival."""

    def __init__(self) -> None:
        self._waiting: deque[asyncio.Future[None]] = deque()

    async def wait(self) -> None:
        """Wait for the turn of a request."""
        loop = asyncio.get_running_loop()
        turn = loop.create_future()
        if not self._waiting:
            loop.call_soon(self._begin, loop)
        self._waiting.append(turn)
        await turn

    def _begin(self, loop: asyncio.AbstractEventLoop) -> None:
        begun = 0
        while self._waiting and begun < BEGUN_PER_ROUND:
            turn = self._waiting.popleft()
            if not turn.done():  # given up
                turn.set_result(None)
                begun += 1
        if self._waiting:
            loop.call_soon(self._begin, loop)
