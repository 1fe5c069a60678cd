"""Token buckets: limits on how much may be spent over time, with a reserve for bursts."""

from __future__ import annotations


class TokenBucket:
    """Amount that may be spent: full at first, it grows with time up to ``burst``. A debt is paid off first."""

    __slots__ = ("_at_s", "_left", "burst", "per_s")

    def __init__(self, per_s: float, burst: float) -> None:
        self.per_s = per_s
        self.burst = burst
        self._left = burst
        self._at_s: float | None = None

    def left(self, now_s: float) -> float:
        """Return what may be spent now; negative for a debt. A clock that runs backwards adds nothing."""
        if self._at_s is None:
            self._at_s = now_s
        elif now_s > self._at_s:
            left = self._left + (now_s - self._at_s) * self.per_s
            self._left, self._at_s = min(self.burst, left), now_s
        return self._left

    def spend(self, amount: float) -> None:
        """Spend an amount, whatever is left; a negative one is given back, up to ``burst``."""
        left = self._left - amount
        self._left = min(self.burst, left)

    def take(self, amount: float, now_s: float) -> bool:
        """Spend an amount if it is there, and return whether it was."""
        if self.left(now_s) < amount:
            return False
        self.spend(amount)
        return True
