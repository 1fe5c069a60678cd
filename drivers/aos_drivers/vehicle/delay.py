"""Age that a vehicle's messages have when they are processed, by the vehicle's own clock."""

from __future__ import annotations

from aos_drivers.vehicle.timesync import ClockEstimator

_LEAST_S = 0.3
"""Shorter delays are those of any link."""
_SAME_CLOCK_S = 0.5
_PROMPT_S = 0.5
"""Longest round trip at which the arrival of a message is compared with its time."""
_LIFE_S = 2.0
"""Time for which one message tells the delay of those that hold no time."""
_LATE_S = 2.0
_IN_TIME_S = 1.0


class TelemetryDelay:
    """Delay of one vehicle's messages.

    A queue, in the socket of a busy station or on a radio, delivers everything, but late. What the vehicle's clock says
    about a message counts as far as its answers to TIMESYNC are late, too: clocks of simulated vehicles run slower than
    ours at times, with answers that come at once.
    """

    __slots__ = ("_delay_s", "_told_at_s", "is_boot_clock", "is_late")

    def __init__(self) -> None:
        self.is_boot_clock = False
        """Whether TIMESYNC tells the time since boot."""
        self._delay_s = 0.0
        self._told_at_s: float | None = None
        self.is_late = False
        """Whether telemetry comes late, as last reported."""

    def compare(self, arrival_offset_s: float | None, clock: ClockEstimator) -> None:
        """Find out whether TIMESYNC tells the same clock as telemetry; ``arrival_offset_s`` is that of telemetry."""
        round_trip_s = clock.last_round_trip_s
        if arrival_offset_s is None or clock.offset_s is None or round_trip_s is None or round_trip_s > _PROMPT_S:
            return
        self.is_boot_clock = abs(clock.offset_s - arrival_offset_s) <= _SAME_CLOCK_S

    def hear(self, boot_s: float, now_s: float, clock: ClockEstimator) -> None:
        """Note a message with its time since boot."""
        if not self.is_boot_clock or clock.offset_s is None:
            return
        delay_s = min(now_s - (boot_s - clock.offset_s), clock.longest_delay_s(now_s))
        self._delay_s = delay_s if delay_s >= _LEAST_S else 0.0
        self._told_at_s = now_s

    def sent_at_s(self, now_s: float) -> float:
        """Return when a message that is processed now was sent."""
        return now_s - self.present_s(now_s) if self._delay_s else now_s

    def present_s(self, now_s: float) -> float:
        """Return the present delay."""
        is_known = self._told_at_s is not None and now_s - self._told_at_s <= _LIFE_S
        return self._delay_s if is_known else 0.0

    def change(self, now_s: float) -> str | None:
        """Return a sentence when telemetry begins to come late, or in time again."""
        if self._told_at_s is None or now_s - self._told_at_s > _LIFE_S:
            return None
        delay_s = self._delay_s
        if not self.is_late and delay_s > _LATE_S:
            self.is_late = True
            return (
                f"telemetry is {delay_s:.0f} s old when it is read: this station or its link is overloaded. "
                "Close other programs on this computer, and check the link"
            )
        if self.is_late and delay_s < _IN_TIME_S:
            self.is_late = False
            return "telemetry arrives in time again"
        return None
