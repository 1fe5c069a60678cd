"""A camera of the fakes that takes images by itself, while somebody waits for them: it owns no task."""

from __future__ import annotations

import math
from collections.abc import Callable

from aos_gcs.errors import CaptureError, NoIntervalError
from aos_gcs.ports import Capture, Clock

_TIME_RESOLUTION_S = 1e-6


class FakeInterval:
    """Images that come every ``period_s``, each ``delay_s()`` after its exposure.

    ``expose`` takes an image; None is a lost one.
    """

    def __init__(
        self, clock: Clock, period_s: float, delay_s: Callable[[], float], expose: Callable[[], Capture | None]
    ) -> None:
        self.period_s = period_s
        self.ended = ""
        """Why the camera takes no images by itself any more."""
        self._clock = clock
        self._delay_s = delay_s
        self._expose = expose
        self._due_s = clock.now_s() + period_s
        self._taken: list[tuple[float, Capture]] = []

    async def next(self, deadline_s: float) -> Capture:
        while True:
            if self.ended:
                raise NoIntervalError(self.ended)
            now_s = self._clock.now_s() + _TIME_RESOLUTION_S
            if now_s >= self._due_s:
                self._due_s += self.period_s
                if (capture := self._expose()) is not None:
                    self._taken.append((now_s + self._delay_s(), capture))
            first = min(self._taken, key=lambda one: one[0], default=None)
            if first is not None and first[0] <= now_s + _TIME_RESOLUTION_S:
                self._taken.remove(first)
                return first[1]
            if now_s >= deadline_s:
                raise CaptureError("the camera delivers nothing")
            due_s = min(self._due_s, math.inf if first is None else first[0], deadline_s)
            await self._clock.sleep(max(0.0, due_s - self._clock.now_s()))
