"""Times that a test moves: real seconds, and those of the event loop."""

from __future__ import annotations

import asyncio

import pytest


class HandTime:
    """Real seconds that pass by hand."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


def stand_still(monkeypatch: pytest.MonkeyPatch, duration_s: float) -> None:
    """Let time pass at once, as when something blocks the loop."""
    loop = asyncio.get_running_loop()
    time = loop.time
    monkeypatch.setattr(loop, "time", lambda: time() + duration_s)
