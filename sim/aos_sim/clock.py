"""Simulated time: a count of whole ticks, so that it neither drifts nor depends on the machine."""

from __future__ import annotations

from dataclasses import dataclass

TICK_US = 20_000
"""One tick of simulated time, 50 Hz: the step of the dynamics and the finest message interval."""

TICK_S = TICK_US / 1e6


@dataclass(frozen=True, slots=True)
class SimTime:
    """A point in simulated time."""

    tick: int
    """Ticks since the vehicles were switched on."""
    start_utc_us: int = 0
    """Microseconds since the Unix epoch at tick 0."""

    @property
    def boot_us(self) -> int:
        """Microseconds since the vehicles were switched on."""
        return self.tick * TICK_US

    @property
    def boot_ms(self) -> int:
        """Milliseconds since the vehicles were switched on."""
        return self.boot_us // 1000

    @property
    def s(self) -> float:
        """Seconds since the vehicles were switched on."""
        return self.boot_us / 1e6

    @property
    def utc_us(self) -> int:
        """Microseconds since the Unix epoch."""
        return self.start_utc_us + self.boot_us

    def later(self, ticks: int = 1) -> SimTime:
        """Return the time ``ticks`` further on."""
        return SimTime(self.tick + ticks, self.start_utc_us)


def fast_utc_us(real_utc_us: int, speed: float, start_utc_s: float) -> int:
    """Return what a clock of some speed shows, in microseconds since the Unix epoch.

    Args:
        real_utc_us: real time, in the same unit.
        speed: its seconds per real second.
        start_utc_s: real time at which it agreed with the real time, in seconds since the Unix epoch.
    """
    start_utc_us = round(1e6 * start_utc_s)
    return start_utc_us + round(speed * (real_utc_us - start_utc_us))


class Pacer:
    """Says how many ticks are due, given the real time that has passed.

    Policy when the machine cannot keep up: simulated time slows down. What is owed beyond ``max_lag_s`` of real time is
    dropped, so that a stall is never followed by a burst that races through seconds of flight, and each tick always has
    the same length.
    """

    def __init__(self, speed: float, max_lag_s: float = 0.25, tick_s: float = TICK_S) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be positive, got {speed}")
        self._ticks_per_real_s = speed / tick_s
        self._max_lag_ticks = max(1.0, max_lag_s * self._ticks_per_real_s)
        self._origin_real_s: float | None = None
        self._done_ticks = 0

    def due_ticks(self, real_s: float) -> int:
        """Return the ticks to be run now; the caller runs them all."""
        if self._origin_real_s is None:
            self._origin_real_s = real_s
        owed = (real_s - self._origin_real_s) * self._ticks_per_real_s - self._done_ticks
        if owed > self._max_lag_ticks:
            self._origin_real_s += (owed - self._max_lag_ticks) / self._ticks_per_real_s
            owed = self._max_lag_ticks
        due = int(owed)
        self._done_ticks += due
        return due

    def delay_s(self, real_s: float) -> float:
        """Return the real seconds until the next tick is due."""
        if self._origin_real_s is None:
            return 0.0
        next_real_s = self._origin_real_s + (self._done_ticks + 1) / self._ticks_per_real_s
        return max(0.0, next_real_s - real_s)
