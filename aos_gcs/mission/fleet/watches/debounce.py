"""Debouncing: a problem counts once it has lasted, and is over once it has been gone for as long."""

from __future__ import annotations

from collections.abc import Hashable


class Debounce:
    """Remembers which problems count, by key, and since when what is seen differs from that.

    Args:
        lasting_s: time for which a problem, or its absence, has to last.
    """

    def __init__(self, lasting_s: float) -> None:
        self._lasting_s = lasting_s
        self._since_s: dict[Hashable, float] = {}
        self._counting: set[Hashable] = set()

    def counts(self, key: Hashable) -> bool:
        """Return whether a problem has lasted, and is not over yet."""
        return key in self._counting

    def has_changed(self, key: Hashable, is_bad: bool, now_s: float) -> bool:
        """Take in what is seen now; return whether the problem begins to count by it, or is over."""
        if is_bad is (key in self._counting):
            self._since_s.pop(key, None)
            return False
        if now_s - self._since_s.setdefault(key, now_s) < self._lasting_s:
            return False
        del self._since_s[key]
        self._counting.symmetric_difference_update({key})
        return True

    def pause(self, key: Hashable) -> None:
        """Note that nothing is seen now: what was seen before does not last."""
        self._since_s.pop(key, None)

    def forget(self, key: Hashable) -> None:
        """Begin anew: the problem does not count."""
        self.pause(key)
        self._counting.discard(key)
