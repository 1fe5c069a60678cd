"""A clock of real seconds that a test moves."""

from __future__ import annotations


class HandTime:
    """Real seconds that pass by hand."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s
