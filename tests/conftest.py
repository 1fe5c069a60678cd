"""Settings of the whole test suite."""

from __future__ import annotations

import asyncio
import os

from hypothesis import settings

# A property that fails must fail for everybody; HYPOTHESIS_PROFILE=explore looks for new examples.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_configure() -> None:
    """Keep looptime from making an event loop, which nobody closes, in synchronous tests that run before others."""
    asyncio.set_event_loop(None)
