"""Message streams of a vehicle and their schedule."""

from __future__ import annotations

from collections.abc import Mapping

from aos_sim.clock import TICK_US

DEFAULT_RATE = 0
OFF = -1


class StreamSchedule:
    """Message intervals in simulated time, in whole ticks; the finest is one tick.

    Args:
        default_intervals_us: the messages sent without being asked.
        phase_ticks: shifts the whole schedule, so that many vehicles do not speak in the same tick.
    """

    def __init__(self, default_intervals_us: Mapping[int, int], phase_ticks: int = 0) -> None:
        self._defaults_us = dict(default_intervals_us)
        self._phase_ticks = phase_ticks
        self._interval_ticks: dict[int, int] = {}
        self._next_tick: dict[int, int] = {}
        self._earliest_tick: int | None = None
        for message_id, interval_us in default_intervals_us.items():
            self.set_interval(message_id, interval_us, tick=0)

    def set_interval(self, message_id: int, interval_us: int, tick: int) -> None:
        """Send a message every ``interval_us``; 0 restores the default, -1 stops it."""
        if interval_us == DEFAULT_RATE:
            interval_us = self._defaults_us.get(message_id, OFF)
        if interval_us < 0:
            self._interval_ticks.pop(message_id, None)
            self._next_tick.pop(message_id, None)
        else:
            interval_ticks = max(1, round(interval_us / TICK_US))
            self._interval_ticks[message_id] = interval_ticks
            self._next_tick[message_id] = tick + 1 + (self._phase_ticks + message_id) % interval_ticks
        self._earliest_tick = min(self._next_tick.values(), default=None)

    def interval_us(self, message_id: int) -> int:
        """Return the interval of a message, -1 if it is not sent."""
        ticks = self._interval_ticks.get(message_id)
        return OFF if ticks is None else ticks * TICK_US

    def due(self, tick: int) -> list[int]:
        """Return the messages to be sent at ``tick`` and plan their next times."""
        if self._earliest_tick is None or tick < self._earliest_tick:
            return []
        due = [message_id for message_id, next_tick in self._next_tick.items() if next_tick <= tick]
        for message_id in due:
            self._next_tick[message_id] = tick + self._interval_ticks[message_id]
        self._earliest_tick = min(self._next_tick.values())
        return due
