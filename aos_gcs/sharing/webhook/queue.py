"""Messages that wait to be delivered, in order. In a full queue the oldest alert goes, or else the oldest of all."""

from __future__ import annotations

import asyncio
from collections import deque

from aos_gcs.sharing.webhook.messages import HookEvent, HookMessage

CAPACITY = 512


class HookQueue:
    """A bounded queue with one reader, which removes a message when it has been delivered."""

    def __init__(self) -> None:
        self._messages: deque[HookMessage] = deque()
        self._is_filled = asyncio.Event()
        self.lost = 0
        """Messages that had to go."""

    def put(self, message: HookMessage) -> None:
        """Append a message; returns at once."""
        if len(self._messages) >= CAPACITY:
            alert = next((one for one in self._messages if one.event is HookEvent.ALERT), self._messages[0])
            self._messages.remove(alert)
            self.lost += 1
        self._messages.append(message)
        self._is_filled.set()

    async def first(self) -> HookMessage:
        """Wait for a message, and return the oldest; it stays in the queue."""
        while not self._messages:
            self._is_filled.clear()
            await self._is_filled.wait()
        return self._messages[0]

    def remove(self, message: HookMessage) -> None:
        """Remove a message that was delivered, or cannot be; it may have been dropped meanwhile."""
        if message in self._messages:
            self._messages.remove(message)

    def __len__(self) -> int:
        return len(self._messages)
