"""The mission's event stream."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager

from aos_gcs.mission.model.events import Event, EventData, EventKind
from aos_gcs.ports import Clock

DEFAULT_CAPACITY = 256


class Subscription:
    """One reader's bounded buffer. When full, its own oldest event is dropped and counted."""

    def __init__(self, capacity: int) -> None:
        self._events: deque[Event] = deque(maxlen=capacity)
        self._ready = asyncio.Event()
        self._closed = False
        self.dropped = 0

    def put(self, event: Event) -> None:
        """Append an event; never blocks."""
        if len(self._events) == self._events.maxlen:
            self.dropped += 1
        self._events.append(event)
        self._ready.set()

    def close(self) -> None:
        """End the iteration once what is buffered has been read."""
        self._closed = True
        self._ready.set()

    def reopen(self) -> None:
        """Let another iteration wait for more."""
        self._closed = False

    def __aiter__(self) -> AsyncIterator[Event]:
        return self

    async def __anext__(self) -> Event:
        while not self._events:
            if self._closed:
                raise StopAsyncIteration
            self._ready.clear()
            await self._ready.wait()
        return self._events.popleft()


class Subscribers:
    """Hands events to every subscriber.

    Buffered per subscriber; when full: drops that subscriber's oldest; many subscribers: each gets every event.
    """

    def __init__(self) -> None:
        self._subscriptions: dict[Subscription, None] = {}

    def hand_out(self, event: Event) -> None:
        """Give an event to all; returns at once."""
        for subscription in self._subscriptions:
            subscription.put(event)

    def attach(self, capacity: int) -> Subscription:
        """Follow the events for as long as this object lives."""
        subscription = Subscription(capacity)
        self._subscriptions[subscription] = None
        return subscription

    @contextmanager
    def subscribe(self, capacity: int = DEFAULT_CAPACITY) -> Iterator[Subscription]:
        """Follow the events for as long as the context is entered."""
        subscription = self.attach(capacity)
        try:
            yield subscription
        finally:
            self._subscriptions.pop(subscription)


class EventStream(Subscribers):
    """Numbers events and hands them to every subscriber."""

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self._clock = clock
        self.count = 0
        """Number of the latest event."""

    def publish(self, kind: EventKind, data: EventData) -> Event:
        """Number, stamp and distribute; returns at once."""
        self.count += 1
        event = Event(self.count, self._clock.utc_s(), kind, data)
        self.hand_out(event)
        return event
