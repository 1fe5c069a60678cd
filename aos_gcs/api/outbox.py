"""What waits to be sent to one client."""

from __future__ import annotations

import asyncio
from collections import deque

from aos_gcs.api.messages import EventMessage, SnapshotMessage

DEFAULT_CAPACITY = 128


class Outbox:
    """Events for one client, numbered when they are taken. ``hello`` has number 1, so the first event has 2.

    Bounded; ``put`` never waits, so that a slow client never slows the mission. Of the snapshots only the newest is
    kept, and nothing is lost with the older ones. When full of other events: drops the oldest, which leaves a gap in
    the numbers.
    """

    def __init__(self, capacity: int = DEFAULT_CAPACITY) -> None:
        self._capacity = capacity
        self._events: deque[EventMessage] = deque()
        self._snapshot: SnapshotMessage | None = None
        self._ready = asyncio.Event()
        self._unseen_losses = 0
        self.seq = 1

    def put(self, message: EventMessage) -> None:
        """Add a message; returns at once."""
        if isinstance(message, SnapshotMessage):
            self._snapshot = message
        else:
            if len(self._events) >= self._capacity:
                self._events.popleft()
                self.lose(1)
            self._events.append(message)
        self._ready.set()

    def lose(self, count: int) -> None:
        """Note that ``count`` events will never come, so that the next message leaves a gap."""
        self._unseen_losses += count

    async def take(self) -> EventMessage:
        """Wait for the next message and number it."""
        message = self._pop()
        while message is None:
            self._ready.clear()
            await self._ready.wait()
            message = self._pop()
        self.seq += 1 + self._unseen_losses
        self._unseen_losses = 0
        return message.model_copy(update={"seq": self.seq})

    def _pop(self) -> EventMessage | None:
        if self._events:
            return self._events.popleft()
        snapshot, self._snapshot = self._snapshot, None
        return snapshot
