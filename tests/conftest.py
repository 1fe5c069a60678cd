"""Settings of the whole test suite."""

from __future__ import annotations

import asyncio


def pytest_configure() -> None:
    """Keep looptime from making an event loop, which nobody closes, in synchronous tests that run before others."""
    asyncio.set_event_loop(None)
