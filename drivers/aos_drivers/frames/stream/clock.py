"""Times of exposure of the frames of a stream.

RTCP's sender reports tie a stream to the time of day of its sender (RFC 3550, section 6.4.1). Without them, or where
they contradict the arrivals, a frame was exposed a configured latency before it arrived; what the network adds to the
quickest of the arrivals is taken off by the stream's own times.
"""

from __future__ import annotations

from dataclasses import dataclass

from aos_drivers.frames.poses.clocks import LeastDelay

SENDER_SIGMA_S = 0.03
"""Standard deviation of times by RTCP: delay from exposure to encoder, clocks of sender and vehicle."""
CREDIBLE_S = 1.0
"""Largest credible difference between the sender's time of day and the arrivals."""


@dataclass(frozen=True, slots=True)
class FrameTime:
    """Time of a frame's exposure, by our clock."""

    at_s: float
    sigma_s: float
    """Standard deviation."""


class StreamClock:
    """The times of one connection's frames."""

    def __init__(self, latency_s: float, latency_sigma_s: float) -> None:
        self._latency_s = latency_s
        self._latency_sigma_s = latency_sigma_s
        self._arrivals = LeastDelay()

    def time_of(self, media_s: float, arrival_s: float, sender_s: float | None) -> FrameTime:
        """Return when a frame was exposed.

        Args:
            media_s: its time within the stream.
            arrival_s: when it arrived.
            sender_s: when it was exposed by the sender's time of day, brought to our clock; None without RTCP.
        """
        self._arrivals.hear(media_s, arrival_s)
        quickest_s = media_s - (self._arrivals.offset_s or 0.0)
        by_arrival_s = quickest_s - self._latency_s
        if sender_s is not None and abs(sender_s - by_arrival_s) <= CREDIBLE_S:
            return FrameTime(sender_s, SENDER_SIGMA_S)
        return FrameTime(by_arrival_s, self._latency_sigma_s)
