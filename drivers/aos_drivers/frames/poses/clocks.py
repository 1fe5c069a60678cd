"""Clocks of a vehicle: time since boot, time of its GPS, and 32 bits of microseconds.

Everything is brought to seconds since the vehicle's boot, the clock of its telemetry, and from there to ours.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

_WRAP_US = 2**32
"""Microseconds since boot, as ArduPilot gives them with a camera's feedback pin, wrap after 71.6 minutes."""
_EPOCH_FROM_US = 10**15
"""Year 2001: later values are times of day, earlier ones count from boot."""
_EPOCH_TO_US = 4 * 10**15
"""Year 2096: later values are errors."""
_WINDOW_S = 5.0
_JUMP_S = 0.5
"""Largest difference between TIMESYNC and arrivals: a larger one is not the delay of a link, but another clock."""
_REBOOT_S = 30.0
"""Jump back in time that means a reboot: no message is delayed so long."""
_LONGEST_DELAY_S = 10.0
"""Longest credible time between an exposure and the message about it; a longer one means a wrong clock."""
_AHEAD_S = 0.5
_SYSTEM_TIME_SIGMA_S = 0.01
_UNKNOWN_SIGMA_S = 0.3
_SIGMAS = 5.0


@dataclass(frozen=True, slots=True)
class ExposureTime:
    """Time of an image's exposure."""

    boot_s: float
    """Seconds since the vehicle's boot."""
    sigma_s: float
    """Standard deviation."""

    def is_since(self, boot_s: float) -> bool:
        """Return whether the image can have been exposed at ``boot_s`` or later, given the uncertainty of its time."""
        return self.boot_s >= boot_s - _SIGMAS * self.sigma_s


class LeastDelay:
    """Another clock against ours, from messages that carry its time: the least delayed of the last 5 s counts.

    Not longer, because simulated vehicles slow down when their machine is busy.
    """

    __slots__ = ("_best",)

    def __init__(self) -> None:
        self._best: deque[tuple[float, float]] = deque()
        """Arrival and offset of each message that no later one improves on: the first is the best."""

    @property
    def offset_s(self) -> float | None:
        """Other clock minus ours, less the least delay; None before a message was heard."""
        return self._best[0][1] if self._best else None

    def hear(self, theirs_s: float, ours_s: float) -> None:
        """Note a message with their time that arrived at our time."""
        offset_s = theirs_s - ours_s
        best = self._best
        if best and offset_s < best[0][1] - _REBOOT_S:
            best.clear()
        while best and best[-1][1] <= offset_s:
            best.pop()
        best.append((ours_s, offset_s))
        from_s = ours_s - _WINDOW_S
        while best[0][0] < from_s:
            best.popleft()


class BootClock:
    """The vehicle's time since boot against our clock and against UTC.

    Ours from the least delayed of the messages that carry a time, until TIMESYNC knows it better.
    """

    __slots__ = ("_arrivals", "_utc_minus_boot_s", "hear_boot")

    def __init__(self) -> None:
        self._arrivals = LeastDelay()
        self.hear_boot = self._arrivals.hear
        """Note the time since boot of a message, and when it arrived (seconds, both)."""
        self._utc_minus_boot_s: float | None = None

    def hear_utc(self, utc_s: float, boot_s: float) -> None:
        """Note a SYSTEM_TIME: the vehicle's UTC at a time since its boot."""
        if utc_s * 1e6 >= _EPOCH_FROM_US:
            self._utc_minus_boot_s = utc_s - boot_s

    def offset_s(self, timesync_offset_s: float | None = None) -> float | None:
        """Return boot time minus our clock; TIMESYNC's where that counts from the boot, too."""
        arrival_s = self._arrivals.offset_s
        if arrival_s is not None and timesync_offset_s is not None and abs(timesync_offset_s - arrival_s) <= _JUMP_S:
            return timesync_offset_s
        return arrival_s

    def boot_s_of_utc(self, utc_s: float) -> float | None:
        """Return the time since boot of a time of day by the vehicle's own GPS; None before it has reported one."""
        return None if self._utc_minus_boot_s is None else utc_s - self._utc_minus_boot_s

    def exposure_time(self, time_us: int, boot_now_s: float) -> ExposureTime:
        """Return the time of an exposure that is reported now.

        Args:
            time_us: microseconds of the Unix epoch, or the lower 32 bits of those since boot; 0 for unknown.
            boot_now_s: time since boot when the report arrived.
        """
        if time_us <= 0:
            return ExposureTime(boot_now_s, _UNKNOWN_SIGMA_S)
        if time_us < _EPOCH_FROM_US:
            boot_s = unwrap_us(time_us, round(boot_now_s * 1e6)) / 1e6
            return self._credible(boot_s, boot_now_s, _SYSTEM_TIME_SIGMA_S)
        from_gps_s = self.boot_s_of_utc(time_us / 1e6)
        if from_gps_s is None:
            return ExposureTime(boot_now_s, _UNKNOWN_SIGMA_S)
        return self._credible(from_gps_s, boot_now_s, _SYSTEM_TIME_SIGMA_S)

    @staticmethod
    def _credible(boot_s: float, boot_now_s: float, sigma_s: float) -> ExposureTime:
        if -_AHEAD_S <= boot_now_s - boot_s <= _LONGEST_DELAY_S:
            return ExposureTime(boot_s, sigma_s)
        return ExposureTime(boot_now_s, _UNKNOWN_SIGMA_S)


def utc_s_of(time_us: int) -> float | None:
    """Return the time of day of a camera's image in seconds; None for what is none, as of a camera without a clock."""
    return time_us / 1e6 if _EPOCH_FROM_US <= time_us < _EPOCH_TO_US else None


def unwrap_us(low_us: int, near_us: int) -> int:
    """Return the number nearest to ``near_us`` whose lower 32 bits are those of ``low_us``."""
    ahead_us = (low_us - near_us) % _WRAP_US
    return near_us + (ahead_us if ahead_us < _WRAP_US // 2 else ahead_us - _WRAP_US)
