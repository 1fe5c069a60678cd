"""A mission as a process needs it that looks at its state alone: no pictures, no steps, and states not too often."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind, StepRecord


class QuietView:
    """Implements ``MissionView`` on another one.

    Args:
        view: mission to look at.
        interval_s: shortest time between two states.
        now_s: clock in real seconds.
    """

    def __init__(self, view: MissionView, interval_s: float, now_s: Callable[[], float]) -> None:
        self._view = view
        self._interval_s = interval_s
        self._now_s = now_s

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        return self._view.snapshot()

    def steps(self) -> Sequence[StepRecord]:
        """Return no steps."""
        return ()

    def picture(self, kind: PictureKind) -> None:
        """Return no raster of any kind."""
        del kind

    @contextmanager
    def subscribe(self) -> Iterator[AsyncIterator[Event]]:
        """Follow the notices, and the states that are due; their numbers have gaps only where the view's own have."""
        with self._view.subscribe() as events:
            yield self._thinned(events)

    async def _thinned(self, events: AsyncIterator[Event]) -> AsyncIterator[Event]:
        number, former, next_s = 0, 0, -math.inf
        async for event in events:
            number += former > 0 and event.seq > former + 1
            former = event.seq
            if event.kind is EventKind.SNAPSHOT:
                if self._now_s() < next_s:
                    continue
                next_s = self._now_s() + self._interval_s
            elif event.kind is not EventKind.NOTICE:
                continue
            number += 1
            yield replace(event, seq=number)
