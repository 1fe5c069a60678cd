"""Messages that wait to be sent to one client."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from aos_gcs.api.events.state import MissionState
from aos_gcs.api.models.messages import HeartbeatMessage

DEFAULT_CAPACITY = 128


class Outbox:
    """Messages for one client, as text.

    Bounded; nothing here ever waits for the client, so that a slow one never slows the mission. When full of events:
    drops the oldest, which the client sees in their numbers. Of the state only the client's revision is kept.

    Args:
        state: state of the mission, shared by all clients.
        hello: makes the first message, and its ``seq``.
        mission_age_s: returns the age of the mission's last sign of life.
        seen: returns the name of the state that clients are shown.
        capacity: events that may wait.
    """

    def __init__(
        self,
        state: MissionState,
        hello: Callable[[], tuple[int, str]],
        mission_age_s: Callable[[], float],
        seen: Callable[[], str],
        capacity: int = DEFAULT_CAPACITY,
    ) -> None:
        self._state = state
        self._hello = hello
        self._mission_age_s = mission_age_s
        self._seen = seen
        self._events: deque[tuple[int, str]] = deque(maxlen=capacity)
        self._ready = asyncio.Event()
        self._greeted = False
        self._revision = 0
        self._seq = 0
        """Number of the latest event that was taken."""

    def put(self, seq: int, text: str) -> None:
        """Add an event."""
        self._events.append((seq, text))
        self._ready.set()

    def nudge(self) -> None:
        """Note that the state has changed."""
        self._ready.set()

    def start_over(self) -> None:
        """Greet the client again: its state is no longer valid."""
        self._greeted = False
        self._ready.set()

    async def take(self) -> str:
        """Wait for the next message."""
        text = self._pop()
        while text is None:
            self._ready.clear()
            await self._ready.wait()
            text = self._pop()
        return text

    def heartbeat(self) -> str:
        """Return the message to send when there is nothing else."""
        message = HeartbeatMessage(seq=self._seq, mission_age_s=self._mission_age_s(), seen=self._seen())
        return message.model_dump_json()

    def _pop(self) -> str | None:
        if not self._greeted:
            self._greeted = True
            self._events.clear()
            self._seq, text = self._hello()
            self._revision = self._state.revision
            return text
        if self._events:
            self._seq, text = self._events.popleft()
            return text
        if self._revision == self._state.revision:
            return None
        text = self._state.message_since(self._revision, self._seq, self._mission_age_s(), self._seen())
        self._revision = self._state.revision
        return text
