"""Packet loss from gaps in sequence numbers."""

from __future__ import annotations

_WINDOW_PACKETS = 1000
_LATE_PACKETS = 32


class LossCounter:
    """Share of lost packets of one (system, component), over about the last thousand."""

    __slots__ = ("_next", "lost", "received")

    def __init__(self) -> None:
        self._next: int | None = None
        self.received = 0.0
        self.lost = 0.0

    def count(self, sequence: int) -> None:
        """Take the sequence number, 0 to 255, of a packet that arrived."""
        self.received += 1
        if self._next is not None and sequence != self._next:
            gap = (sequence - self._next) % 256
            if gap >= 256 - _LATE_PACKETS:  # late or repeated: it had been counted as lost
                self.lost = max(0.0, self.lost - 1)
                return
            self.lost += gap
        self._next = (sequence + 1) % 256
        if self.received + self.lost > _WINDOW_PACKETS:
            self.received /= 2
            self.lost /= 2
