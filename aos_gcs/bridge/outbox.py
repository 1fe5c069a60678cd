"""What waits to be sent to the interface: bounded, and read by the sender alone, so that the flight never waits."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

CAPACITY: Final = 256
"""Events that may wait; with more, the interface is told everything anew."""

Compose = Callable[[], bytes]
"""Returns a message, at the time at which it is sent; empty if it is not needed any more."""


@dataclass(slots=True)
class _Entry:
    compose: Compose | None


@dataclass(slots=True, eq=False)
class BridgeOutbox:
    """Messages for one connection. Answers come first; of the state only the latest is kept.

    Args:
        greeting: yields the messages that a new interface needs before all others.
    """

    greeting: Callable[[], Iterator[bytes]]
    _greeting: Iterator[bytes] = field(init=False)
    _answers: deque[Compose] = field(default_factory=deque)
    _events: deque[_Entry] = field(default_factory=deque)
    _state: _Entry | None = None
    _ready: asyncio.Event = field(default_factory=asyncio.Event)

    def __post_init__(self) -> None:
        self._greeting = self.greeting()
        self._ready.set()

    def put_answer(self, compose: Compose) -> None:
        """Add an answer; their number is bounded by that of the commands in progress."""
        self._answers.append(compose)
        self._ready.set()

    def put_state(self, compose: Compose) -> None:
        """Add a state, in the place of one that still waits."""
        if self._state is not None:
            self._state.compose = None
        self._state = self._add(compose)

    def put_event(self, compose: Compose) -> None:
        """Add an event."""
        self._add(compose)

    def start_over(self) -> None:
        """Greet the interface anew, since it has lost events."""
        self._events.clear()
        self._state = None
        self._greeting = self.greeting()
        self._ready.set()

    async def take(self) -> bytes:
        """Wait for the next message."""
        while not (message := self._next()):
            self._ready.clear()
            await self._ready.wait()
        return message

    def _add(self, compose: Compose) -> _Entry:
        entry = _Entry(compose)
        self._events.append(entry)
        if len(self._events) > CAPACITY:
            self.start_over()
        self._ready.set()
        return entry

    def _next(self) -> bytes:
        """Return the next message; empty if none waits."""
        if self._answers:
            return self._answers.popleft()()
        message = next(self._greeting, b"")
        while not message and self._events:
            entry = self._events.popleft()
            if entry is self._state:
                self._state = None
            message = b"" if entry.compose is None else entry.compose()
        return message
